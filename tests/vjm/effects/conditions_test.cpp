// Parts that lag behind the temperature that is read.
#include "kinetostat/vjm/effects/conditions.h"

#include <cmath>

#include <gtest/gtest.h>

namespace kinetostat::vjm::conditions_test {
namespace {

TemperaturePast past_of(std::vector<TemperatureAt> readings) {
  const std::size_t count = readings.size();
  return {std::make_shared<const std::vector<TemperatureAt>>(std::move(readings)), count};
}

// A day of readings that come at uneven times.
std::vector<TemperatureAt> day() {
  std::vector<TemperatureAt> result;
  double time = 0;
  for (int i = 0; i < 200; ++i) {
    result.push_back({time, 20 + 4 * std::sin(time / 4000) + 0.1 * std::cos(7. * i)});
    time += 20 + 15 * std::sin(3. * i);
  }
  return result;
}

// Closed form of a ramp T = s t: T' - T = -s lag (1 - exp(-t/lag)).
TEST(TemperatureLag, OfARampIsThatOfAFirstOrderSystem) {
  const double s = 2e-3, lag = 700;
  const TemperaturePast ramp = past_of({{0, 20}, {100, 20.2}, {450, 20.9}, {1000, 22}});
  const double e = std::exp(-1000 / lag);
  const TemperatureLag is = temperature_lag(ramp, lag);
  EXPECT_NEAR(is.behind, -s * lag * (1 - e), 1e-12);
  EXPECT_NEAR(is.by_lag, -s * (1 - e) + s * 1000 / lag * e, 1e-15);
}

// lag dT'/dt = T - T' in small steps of Heun's method.
TEST(TemperatureLag, IsTheSolutionOfItsDifferentialEquation) {
  const std::vector<TemperatureAt> readings = day();
  const double lag = 1300;
  double part = readings[0].temperature;
  for (std::size_t i = 1; i < readings.size(); ++i) {
    const TemperatureAt &a = readings[i - 1], &b = readings[i];
    constexpr int steps = 200;
    const double h = (b.time - a.time) / steps;
    for (int k = 0; k < steps; ++k) {
      const auto read = [&](double at) {
        return a.temperature + (b.temperature - a.temperature) * at / steps;
      };
      const double first = (read(k) - part) / lag;
      const double second = (read(k + 1) - (part + h * first)) / lag;
      part += h * (first + second) / 2;
    }
  }
  EXPECT_NEAR(temperature_lag(past_of(readings), lag).behind, part - readings.back().temperature,
              1e-9);
}

TEST(TemperatureLag, DerivativeIsThatOfCentralDifferences) {
  const TemperaturePast past = past_of(day());
  for (const double lag : {5., 60., 900., 1e5}) {
    const double h = 1e-4 * lag;
    const double slope =
        (temperature_lag(past, lag + h).behind - temperature_lag(past, lag - h).behind) / (2 * h);
    EXPECT_NEAR(temperature_lag(past, lag).by_lag, slope, 1e-7 * std::abs(slope) + 1e-13) << lag;
  }
}

// Without a lag it is the temperature that is read, and the derivative goes on to that.
TEST(TemperatureLag, GoesToNothing) {
  const TemperaturePast past = past_of(day());
  EXPECT_EQ(temperature_lag(past, 0).behind, 0);
  EXPECT_NEAR(temperature_lag(past, 0).by_lag, temperature_lag(past, 1e-3).by_lag, 1e-12);
  EXPECT_EQ(temperature_lag({}, 500).behind, 0);
  EXPECT_EQ(temperature_lag(past_of({{0, 25}}), 500).behind, 0);
}

// What was long ago plays no part; what was read twice at a time is a step.
TEST(TemperatureLag, ForgetsAndSteps) {
  std::vector<TemperatureAt> readings = {{0, 500}, {1, 20}};
  for (int i = 2; i < 1000; ++i) readings.push_back({10. * i, 20 + 0.01 * (i % 7)});
  const TemperatureLag hot = temperature_lag(past_of(readings), 20);
  readings[0].temperature = 20;
  EXPECT_EQ(temperature_lag(past_of(readings), 20).behind, hot.behind);
  EXPECT_DOUBLE_EQ(temperature_lag(past_of({{0, 20}, {0, 23}}), 50).behind, -3);
}

}  // namespace
}  // namespace kinetostat::vjm::conditions_test
