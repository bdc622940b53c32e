// What each effect looks like to somebody who compares its readings with the model without it.
#include <algorithm>
#include <set>

#include <boost/math/distributions/chi_squared.hpp>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include "kinetostat/calibration/comparison/compare.h"

#include "calibration/synthetic.h"
#include "vjm/effect_catalogue.h"

namespace kinetostat::calibration::effect_signature_test {
namespace {

using vjm::test::Bench;

// Four postures, three directions, a closed cycle of nine loads in each; two sessions, the second
// after a night; the temperature wanders by itself.
Campaign plan_for(const Bench& bench, bool arm, DisplacementKind displacement) {
  Campaign campaign;
  campaign.displacement = displacement;
  campaign.file = campaign.readings_file = "plan";
  campaign.noise_stated = true;
  campaign.sessions = {"evening", "morning"};
  for (int pose = 0; pose < 4; ++pose) {
    const double a = pose % 2 == 0 ? 1 : -1, b = pose < 2 ? 1 : -1;
    Configuration configuration;
    if (arm) {
      configuration.joints = {{"carousel.q1", 0.3 * a},
                              {"arm.q3", -0.35 + 0.3 * b},
                              {"arm.q4", 0.4 * b},
                              {"arm.q5", 0.5 + 0.3 * a}};
    } else {
      configuration.target = spatial::Pose::translation({0.05 * a, 0.04 * b, -0.03 * a + 0.02 * b});
    }
    for (const auto& [joint, angle] : configuration.joints)
      campaign.joint_columns[joint] = {.column = joint, .turns = true};
    campaign.configurations.push_back(configuration);
  }
  const double levels[] = {0, 0.5, 1, 0.5, 0, -0.5, -1, -0.5, 0};
  for (Eigen::Index axis = 0; axis < 3; ++axis)
    for (std::size_t pose = 0; pose < 4; ++pose)
      for (int k = 0; k < 9; ++k) {
        const auto n = static_cast<double>(campaign.readings.size());
        Reading reading;
        reading.id = fmt::format("p{}{}{}", pose, "xyz"[axis], k);
        reading.cycle = fmt::format("p{}{}", pose, "xyz"[axis]);
        reading.step = k;
        reading.session = n < 54 ? 0 : 1;
        reading.time = 90 * n + (n < 54 ? 0 : 43200);
        reading.temperature = 21 + 4 * std::sin(2.4 * n);
        reading.configuration = pose;
        reading.load.force = bench.force * levels[k] * spatial::Vector3::Unit(axis);
        reading.displacement.setZero();
        reading.sigma.setOnes();
        campaign.readings.push_back(reading);
      }
  return campaign;
}

std::vector<Eigen::VectorXd> predicted(const Bench& bench, const std::vector<vjm::Effect>& effects,
                                       const Campaign& campaign) {
  common::Progress silent;
  const Predictions p = Predictor(bench.manipulator, effects, campaign, 1, silent)
                            .predict({}, Eigen::VectorXd(), false, silent);
  EXPECT_FALSE(p.failure) << p.failure->reason;
  return p.displacement;
}

// Differences to the unloaded robot for effects that yield to the load; poses for effects that
// displace the robot without load, which are not observable in differences.
DisplacementKind kind_of_readings(const vjm::Effect& effect) {
  return vjm::test::displaces_without_load(effect.kind->name) ? DisplacementKind::absolute
                                                              : DisplacementKind::difference;
}

// Readings of the robot with the effect; the noise of each kind is 0.7 times the effect's rms.
// `noise`: as a share of that; without it the readings show the effect alone.
Campaign measured(const Bench& bench, const vjm::Effect& effect, bool arm, double noise = 1) {
  Campaign campaign = plan_for(bench, arm, kind_of_readings(effect));
  const std::vector<Eigen::VectorXd> plain = predicted(bench, {}, campaign);
  const std::vector<Eigen::VectorXd> with = predicted(bench, {effect}, campaign);
  double translation = 0, rotation = 0;
  for (std::size_t i = 0; i < plain.size(); ++i) {
    translation += (with[i] - plain[i]).head<3>().squaredNorm();
    rotation += (with[i] - plain[i]).tail<3>().squaredNorm();
  }
  const double n = 3 * static_cast<double>(plain.size());
  kinetostat::test::Random random(17);
  const auto normal = [&random] {  // Irwin and Hall: nearly normal, variance 1
    double sum = -6;
    for (int k = 0; k < 12; ++k) sum += random.uniform(0, 1);
    return sum;
  };
  for (std::size_t i = 0; i < plain.size(); ++i) {
    Reading& reading = campaign.readings[i];
    reading.sigma.head<3>().setConstant(0.7 * std::sqrt(translation / n));
    reading.sigma.tail<3>().setConstant(0.7 * std::sqrt(std::max(rotation, translation) / n));
    for (Eigen::Index k = 0; k < 6; ++k)
      reading.displacement[k] = with[i][k] + noise * normal() * reading.sigma[k];
  }
  return campaign;
}

vjm::Robot robot_with(const Bench& bench, const std::vector<vjm::Effect>& effects) {
  return {.file = "bench",
          .name = bench.name,
          .units = {},
          .manipulator = vjm::with_effects(bench.manipulator, effects),
          .uncertain = {},
          .link_files = {},
          .effects = effects,
          .bare = bench.manipulator};
}

// What a comparison finds, most significant first: factors, "odd" or "even", "loop".
std::vector<std::string> findings(const Assessment& assessment) {
  std::vector<std::pair<double, std::string>> all;
  const Patterns& p = assessment.patterns;
  for (const Pattern& factor : p.factors) all.emplace_back(factor.holm_p_value(), factor.factor);
  if (p.reversal)
    all.emplace_back(p.reversal->test.holm_p_value, p.reversal->odd_share > 0.5 ? "odd" : "even");
  if (p.loops.area) all.emplace_back(p.loops.area->holm_p_value, "loop");
  if (p.loops.return_to_zero)
    all.emplace_back(p.loops.return_to_zero->holm_p_value, "return to zero");
  std::stable_sort(all.begin(), all.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<std::string> names;
  for (const auto& [value, name] : all)
    if (value < significance_level) names.push_back(name);
  return names;
}

std::string worst_axis(const Assessment& assessment) {
  const auto worst =
      std::max_element(assessment.by_component.begin(), assessment.by_component.end(),
                       [](const auto& a, const auto& b) { return a.share < b.share; });
  return component_names[static_cast<std::size_t>(worst->component)];
}

// Where each kind shows. What yields to the load follows its direction and changes sign with it;
// what displaces the unloaded robot stays when the load is reversed and follows the posture.
const std::set<std::string>& expected(const std::string& kind) {
  static const std::set<std::string> load = {"direction of load", "level of load", "odd"};
  static const std::set<std::string> posture = {"posture", "reach", "even"};
  static const std::set<std::string> temperature = {"temperature"};
  // The weight of an arm that grows softer in a cycle lets it sag.
  static const std::set<std::string> softer = {"direction of load", "odd", "temperature"};
  static const std::set<std::string> time = {"time in the session"};
  static const std::set<std::string> some = {"time", "time in the session", "session", "posture"};
  static const std::set<std::string> history = {"loop", "branch", "return to zero"};
  if (kind == "friction" || kind == "load_friction" || kind == "gauge_play") return history;
  if (kind == "creep") return history;
  if (kind == "thermal_expansion") return temperature;
  if (kind == "thermal_softening") return softer;
  if (kind == "session_drift") return time;
  if (kind == "target_slip" || kind == "cycle_offset") return some;
  for (const char* offset : {"geometric_error", "joint_offset", "eccentricity",
                             "transmission_ratio", "preload", "gravity_compensator", "self_weight",
                             "payload", "sensor_frame", "target_lever_arm", "wrench_zero"})
    if (kind == offset) return posture;
  return load;
}

double excess(const PatternGroup& group) { return group.share - group.share_of_values; }

// The group that the sentence about a pattern names.
const PatternGroup& named(const Pattern& pattern) {
  return *std::max_element(pattern.groups.begin(), pattern.groups.end(),
                           [](const auto& a, const auto& b) { return excess(a) < excess(b); });
}

// Every dependence that noisy readings show is one of the effect itself, and the group, component
// and sign that are named are those that the effect changes most, or nearly.
void expect_points_to_the_effect(const Assessment& noisy, const Assessment& clear,
                                 const std::string& who) {
  for (const Pattern& pattern : noisy.patterns.factors) {
    if (pattern.holm_p_value() >= 1e-4) continue;  // beyond doubt
    const auto truth =
        std::find_if(clear.patterns.factors.begin(), clear.patterns.factors.end(),
                     [&](const Pattern& other) { return other.factor == pattern.factor; });
    ASSERT_NE(truth, clear.patterns.factors.end()) << who;
    const PatternGroup& worst = named(pattern);
    const auto same = std::find_if(truth->groups.begin(), truth->groups.end(),
                                   [&](const auto& group) { return group.label == worst.label; });
    ASSERT_NE(same, truth->groups.end()) << who;
    EXPECT_GT(excess(*same), 0.3 * excess(named(*truth)) - 0.02)
        << who << ": " << pattern.factor << " is blamed at " << worst.label << ", not at "
        << named(*truth).label;
  }
  const auto& reversal = noisy.patterns.reversal;
  if (reversal && reversal->test.holm_p_value < 1e-4) {
    EXPECT_EQ(reversal->odd_share > 0.5, clear.patterns.reversal->odd_share > 0.5) << who;
  }
}

// What stands between the base and the platform along one axis of an Orthoglide moves it along that
// axis, under loads along it: known from the robot, not from any model.
std::string axis_of(const vjm::Effect& effect) {
  if (effect.at.size() < 2 || effect.at[1] != '.') return {};
  const std::string place = effect.at.substr(2);
  const std::string& kind = effect.kind->name;
  if (kind == "bearing_compliance" || kind == "bearing_tilt" || kind == "base_tilt")
    return {};  // they turn it as well
  if (place == "base" || place == "rho") return effect.at.substr(0, 1);
  return {};
}

class EffectSignature : public testing::TestWithParam<std::pair<bool, std::size_t>> {};

std::vector<std::pair<bool, std::size_t>> every_effect() {
  std::vector<std::pair<bool, std::size_t>> all;
  for (const bool arm : {false, true}) {
    const Bench bench = arm ? vjm::test::arm_bench() : vjm::test::parallel_bench();
    for (std::size_t e = 0; e < bench.effects.size(); ++e) all.emplace_back(arm, e);
  }
  return all;
}

INSTANTIATE_TEST_SUITE_P(Catalogue, EffectSignature, testing::ValuesIn(every_effect()));

TEST_P(EffectSignature, IsSeenWhereItIsAndGoneWithTheEffect) {
  const bool arm = GetParam().first;
  const Bench bench = arm ? vjm::test::arm_bench() : vjm::test::parallel_bench();
  const vjm::Effect& effect = bench.effects[GetParam().second];
  const Campaign campaign = measured(bench, effect, arm);
  common::Progress silent;
  const Comparison plain = compare(robot_with(bench, {}), campaign, 1, silent);
  const Comparison with = compare(robot_with(bench, {effect}), campaign, 1, silent);
  EXPECT_EQ(plain.nominal.adequacy, Adequacy::inadequate) << effect.kind->name;

  const std::vector<std::string> found = findings(plain.nominal);
  ASSERT_FALSE(found.empty()) << effect.kind->name;
  const std::string who = effect.kind->name + " on the " + bench.name;
  const Assessment clear =
      compare(robot_with(bench, {}), measured(bench, effect, arm, 0), 1, silent).nominal;
  expect_points_to_the_effect(plain.nominal, clear, who);
  const auto share = [&clear](const std::string& axis) {
    for (const ResidualStatistics& s : clear.by_component)
      if (component_names[static_cast<std::size_t>(s.component)] == axis) return s.share;
    return 0.0;
  };
  EXPECT_GT(share(worst_axis(plain.nominal)), 0.8 * share(worst_axis(clear))) << who;
  if (const std::string axis = axis_of(effect); !arm && !axis.empty()) {
    EXPECT_EQ(worst_axis(plain.nominal), "d" + axis) << who;
    for (const Pattern& pattern : plain.nominal.patterns.factors)
      if (pattern.factor == "direction of load" && pattern.holm_p_value() < 1e-4) {
        EXPECT_EQ(named(pattern).label.substr(1), "f" + axis) << who;
      }
  }
  // What a joint under constant weight does with time, and what a joint that hardly moves at some
  // postures does, shows there first; the loop comes right behind. What is of some readings only
  // shows in all that these have in common.
  const bool history = effect.kind->history > 0 || effect.kind->acts_on_numbers();
  const auto end = found.begin() + std::min<std::ptrdiff_t>(history ? 2 : 1, std::ssize(found));
  EXPECT_TRUE(std::any_of(
      found.begin(), end,
      [&](const std::string& name) { return expected(effect.kind->name).contains(name); }))
      << effect.kind->name << " on the " << bench.name << " shows in "
      << fmt::format("{}", fmt::join(found, ", "));

  const ChiSquareTest& chi = *with.nominal.chi_square;
  const boost::math::chi_squared law(static_cast<double>(chi.degrees_of_freedom));
  const double dof = static_cast<double>(chi.degrees_of_freedom);
  EXPECT_GT(chi.reduced(), boost::math::quantile(law, 0.025) / dof) << effect.kind->name;
  EXPECT_LT(chi.reduced(), boost::math::quantile(law, 0.975) / dof) << effect.kind->name;

  std::string list = worst_axis(plain.nominal);
  for (const std::string& name : found) list += ", " + name;
  RecordProperty("row", fmt::format("| `{}` | {} | {} | {:.2f} | {:.3f} |", effect.kind->name,
                                    bench.name + ", " + effect.at, list,
                                    plain.nominal.chi_square->reduced(), chi.reduced()));
}

// The value whose half the readings miss most.
Eigen::Index strongest_value(const Bench& bench, const vjm::Effect& effect, bool arm) {
  const Campaign campaign = plan_for(bench, arm, kind_of_readings(effect));
  const std::vector<Eigen::VectorXd> all = predicted(bench, {effect}, campaign);
  Eigen::Index strongest = 0;
  double most = 0;
  for (Eigen::Index v = 0; v < effect.values.size(); ++v) {
    vjm::Effect half = effect;
    const vjm::EffectParameter& parameter = effect.kind->parameters[static_cast<std::size_t>(v)];
    if (v > 0 && parameter.required) continue;  // a shape, not a size
    if (parameter.name == "order") continue;    // has a minimum every period
    half.values[v] = (effect.values[v] + parameter.none) / 2;
    const std::vector<Eigen::VectorXd> other = predicted(bench, {half}, campaign);
    double squares = 0;
    for (std::size_t i = 0; i < all.size(); ++i) squares += (all[i] - other[i]).squaredNorm();
    if (squares > most) most = squares, strongest = v;
  }
  return strongest;
}

// A value, started halfway to none, comes back to what it was.
TEST_P(EffectSignature, IsFitted) {
  const bool arm = GetParam().first;
  const Bench bench = arm ? vjm::test::arm_bench() : vjm::test::parallel_bench();
  const vjm::Effect& truth = bench.effects[GetParam().second];
  const Eigen::Index v = strongest_value(bench, truth, arm);
  const double none = truth.kind->parameters[static_cast<std::size_t>(v)].none;
  vjm::Effect guess = truth;
  guess.values[v] = (truth.values[v] + none) / 2;
  vjm::Robot robot = robot_with(bench, {guess});
  robot.uncertain_values = {{0, v}};
  common::Progress silent;
  const Comparison c = compare(robot, measured(bench, truth, arm), 1, silent);
  ASSERT_TRUE(c.fitted) << c.refit_failure;
  const ParameterEstimate& e = c.fitted->fit.parameters.at(0);
  EXPECT_LT(std::abs(e.value - truth.values[v]), 4 * e.standard_error) << e.parameter.name;
  EXPECT_LT(e.standard_error, 0.5 * std::abs(truth.values[v] - none)) << e.parameter.name;
}

}  // namespace
}  // namespace kinetostat::calibration::effect_signature_test
