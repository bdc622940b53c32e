#include "kinetostat/calibration/patterns.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <fmt/format.h>

#include "kinetostat/calibration/load_history.h"

namespace kinetostat::calibration {
namespace {

using Eigen::Index;
using spatial::Vector6;

// Residuals this small beside what was measured are rounding of the equilibrium.
constexpr double rounding = 1e-9;

// A whitened residual; its channel is its component, or 0 along the load.
struct Sample {
  std::size_t reading = 0;
  std::size_t channel = 0;
  double value = 0;
};

double p_of_f(double f, Index n, Index d) {
  const boost::math::fisher_f law(static_cast<double>(n), static_cast<double>(d));
  return boost::math::cdf(boost::math::complement(law, f));
}

// Sum of squares that a dependence explains, and how many constants that takes.
struct Explained {
  double sum = 0, total = 0;
  Index degrees_of_freedom = 0, channels = 0, values = 0;
};

std::optional<PatternTest> test_of(const Explained& e, Index parameters) {
  const Index within = e.values - e.channels - e.degrees_of_freedom - parameters;
  const double rest = e.total - e.sum;
  if (e.degrees_of_freedom < 1 || within < 1 || !(rest > rounding * rounding * e.total)) return {};
  PatternTest test;
  test.degrees_of_freedom = e.degrees_of_freedom;
  test.degrees_of_freedom_within = within;
  test.f = (std::max(0.0, e.sum) / static_cast<double>(e.degrees_of_freedom)) /
           (rest / static_cast<double>(within));
  test.p_value = p_of_f(test.f, e.degrees_of_freedom, within);
  return test;
}

struct Mean {
  double count = 0, sum = 0;
  double value() const { return sum / count; }
};

// One-way analysis of variance, every channel about its own mean.
Explained between_groups(const std::vector<Sample>& samples, const std::vector<int>& group) {
  std::map<std::size_t, Mean> channels;
  std::map<std::pair<std::size_t, int>, Mean> cells;
  for (const Sample& s : samples)
    for (Mean* mean : {&channels[s.channel], &cells[{s.channel, group[s.reading]}]})
      ++mean->count, mean->sum += s.value;
  Explained e;
  for (const Sample& s : samples) {
    const double centre = channels[s.channel].value();
    e.total += std::pow(s.value - centre, 2);
    e.sum += std::pow(cells[{s.channel, group[s.reading]}].value() - centre, 2);
  }
  e.values = static_cast<Index>(samples.size());
  e.channels = static_cast<Index>(channels.size());
  e.degrees_of_freedom = static_cast<Index>(cells.size()) - e.channels;
  return e;
}

// Straight line over a number, one slope a channel.
Explained along_line(const std::vector<Sample>& samples, const std::vector<double>& x) {
  struct Sums {
    Mean x, y;
    double xx = 0, xy = 0, yy = 0;
  };
  std::map<std::size_t, Sums> channels;
  for (const Sample& s : samples) {
    Sums& c = channels[s.channel];
    ++c.x.count, c.x.sum += x[s.reading];
    ++c.y.count, c.y.sum += s.value;
  }
  for (const Sample& s : samples) {
    Sums& c = channels[s.channel];
    const double dx = x[s.reading] - c.x.value(), dy = s.value - c.y.value();
    c.xx += dx * dx, c.xy += dx * dy, c.yy += dy * dy;
  }
  Explained e;
  for (const auto& [channel, c] : channels) {
    e.total += c.yy;
    if (!(c.xx > 0)) continue;
    e.sum += c.xy * c.xy / c.xx;
    ++e.degrees_of_freedom;
  }
  e.values = static_cast<Index>(samples.size());
  e.channels = static_cast<Index>(channels.size());
  return e;
}

// What a residual may depend on: a group for every reading (-1: not known), or a number.
struct Factor {
  std::string name;
  std::vector<int> group;
  std::vector<std::string> labels;
  std::vector<double> number = {};
  bool along_load = false;
};

class Finder {
 public:
  Finder(const Campaign& campaign, const std::vector<Vector6>& residual,
         const std::vector<Vector6>& whitened, const std::vector<Vector6>& work, Index parameters,
         const Noise& noise)
      : campaign_(campaign),
        residual_(residual),
        whitened_(whitened),
        work_(work),
        parameters_(parameters),
        noise_(noise) {
    for (std::size_t i = 0; i < campaign.readings.size(); ++i)
      for (Index k = 0; k < 6; ++k)
        if (campaign.readings[i].uses(k) && (noise.comparable || !is_rotation(k)))
          components_.push_back({i, static_cast<std::size_t>(k), whitened[i][k]});
    find_along_load();
  }

  Patterns find() {
    Patterns result;
    if (is_rounding()) return result;
    for (const Factor& factor : factors()) add(factor, result);
    result.reversal = reversal();
    result.loops = loops();
    result.loop_area = loop_test(area_);
    result.return_to_zero = loop_test(return_);
    correct(result);
    return result;
  }

 private:
  const Reading& reading(std::size_t i) const { return campaign_.readings[i]; }

  bool is_rounding() const {
    double error = 0, size = 0;
    for (const Sample& s : components_) {
      const auto k = static_cast<Index>(s.channel);
      const double sigma = noise_.sigma[s.reading][k];
      error += s.value * s.value;
      size += std::pow(reading(s.reading).displacement[k] / sigma, 2);
    }
    return !(error > rounding * rounding * size);
  }

  void find_along_load() {
    for (std::size_t i = 0; i < campaign_.readings.size(); ++i) {
      const Vector6 u = direction_seen(i);
      double sum = 0, squares = 0;
      for (Index k = 0; k < 6; ++k)
        if (reading(i).uses(k)) sum += u[k] * whitened_[i][k], squares += u[k] * u[k];
      // Less than this share of the load's direction is measured: it tells nothing.
      if (squares > 1e-6) along_load_.push_back({i, 0, sum / std::sqrt(squares)});
    }
  }

  // Direction of the load in the axes of the displacements.
  Vector6 direction_seen(std::size_t i) const {
    const Vector6& w = work_[i];
    return direction_of({.force = w.head<3>(), .moment = w.tail<3>()});
  }

  std::vector<Factor> factors() const {
    std::vector<Factor> all = {postures(), reach(),         load_directions(),
                               levels(),   load_branches(), sessions()};
    all.push_back(by_number("time", campaign_.units.time, [](const Reading& r) { return r.time; }));
    if (sessions_start_apart()) all.push_back(time_in_session());
    all.push_back(by_number("temperature", "", [](const Reading& r) { return r.temperature; }));
    all.push_back(settings());
    for (const Covariate& c : campaign_.covariates) all.push_back(covariate(c));
    return all;
  }

  // Readings grouped by a text; the empty text: not known.
  template <class Text>
  Factor by_text(const std::string& name, const Text& text) const {
    Factor factor{.name = name, .group = {}, .labels = {}};
    std::map<std::string, int> known;
    for (std::size_t i = 0; i < campaign_.readings.size(); ++i)
      if (const std::string label = text(i); is_used(reading(i)) && !label.empty())
        known.emplace(label, 0);
    for (auto& [label, number] : known) {
      number = static_cast<int>(factor.labels.size());
      factor.labels.push_back(label);
    }
    for (std::size_t i = 0; i < campaign_.readings.size(); ++i) {
      const auto found = known.find(text(i));
      factor.group.push_back(found == known.end() ? -1 : found->second);
    }
    return factor;
  }

  // Readings with a number; for shares they are split in thirds of its distinct values.
  template <class Get>
  Factor by_number(const std::string& name, const std::string& unit, const Get& get) const {
    Factor factor{.name = name, .group = {}, .labels = {}};
    std::vector<double> used;
    for (const Reading& r : campaign_.readings) {
      const std::optional<double> value = get(r);
      factor.number.push_back(value.value_or(std::nan("")));
      if (value && is_used(r)) used.push_back(*value);
    }
    const std::vector<double> values = distinct_values(used);
    if (values.size() < 3) return grouped(std::move(factor), values, values.size(), unit);
    return grouped(std::move(factor), values, 3, unit);
  }

  Factor grouped(Factor factor, const std::vector<double>& values, std::size_t bins,
                 const std::string& unit) const {
    const double slack =
        values.empty() ? 0 : 1e-8 * std::max(std::abs(values.front()), std::abs(values.back()));
    const double scale = unit.empty() ? 1 : spatial::parse_unit(unit).factor;
    std::vector<double> starts;
    for (std::size_t b = 0; b < bins; ++b) {
      const std::size_t first = b * values.size() / bins;
      const std::size_t last = (b + 1) * values.size() / bins - 1;
      starts.push_back(values[first]);
      factor.labels.push_back(first == last
                                  ? fmt::format("{:.4g} {}", values[first] / scale, unit)
                                  : fmt::format("{:.4g} to {:.4g} {}", values[first] / scale,
                                                values[last] / scale, unit));
      if (factor.labels.back().back() == ' ') factor.labels.back().pop_back();
    }
    for (const double x : factor.number) {
      int group = -1;
      for (std::size_t b = 0; b < bins && !std::isnan(x); ++b)
        if (x >= starts[b] - slack) group = static_cast<int>(b);
      factor.group.push_back(group);
    }
    return factor;
  }

  std::string posture_label(const Configuration& c) const {
    const double unit = spatial::parse_unit(campaign_.units.length).factor;
    if (c.target) {
      const spatial::Vector3 p = c.target->position() / unit;
      return fmt::format("({:.4g}, {:.4g}, {:.4g}) {}", p.x(), p.y(), p.z(),
                         campaign_.units.length);
    }
    std::string label;
    for (const auto& [joint, value] : c.joints)
      label += fmt::format("{}{} = {:.4g}", label.empty() ? "" : ", ", joint, value);
    return label;
  }

  Factor postures() const {
    Factor factor{.name = "posture", .group = {}, .labels = {}};
    for (const Configuration& c : campaign_.configurations)
      factor.labels.push_back(posture_label(c));
    for (const Reading& r : campaign_.readings)
      factor.group.push_back(static_cast<int>(r.configuration));
    return factor;
  }

  Factor reach() const {
    return by_number("reach", campaign_.units.length, [this](const Reading& r) {
      const auto& target = campaign_.configurations[r.configuration].target;
      return target ? std::optional(target->position().norm()) : std::nullopt;
    });
  }

  Factor load_directions() const {
    return by_text("direction of load", [this](std::size_t i) -> std::string {
      const Vector6 u = direction_of(reading(i).load);
      for (Index k = 0; k < 6; ++k)  // the first of equals, whatever rounding makes of them
        if (!u.isZero(0) && std::abs(u[k]) >= u.cwiseAbs().maxCoeff() - rounding)
          return fmt::format(
              "{}{}", u[k] > 0 ? "+" : "-",
              std::array{"fx", "fy", "fz", "mx", "my", "mz"}[static_cast<std::size_t>(k)]);
      return {};
    });
  }

  // Forces only, or moments where there is no force at all: they have no common scale.
  Factor levels() const {
    const bool forces = std::any_of(campaign_.readings.begin(), campaign_.readings.end(),
                                    [](const Reading& r) { return !r.load.force.isZero(0); });
    const std::string unit =
        forces ? campaign_.units.force : campaign_.units.force + " " + campaign_.units.length;
    Factor factor = by_number("level of load", unit, [forces](const Reading& r) {
      const bool has = forces ? !r.load.force.isZero(0) : !r.load.moment.isZero(0);
      return has ? std::optional(level_of(r.load)) : std::nullopt;
    });
    factor.number.clear();  // a curve, not a line
    factor.along_load = true;
    return factor;
  }

  Factor load_branches() const {
    const std::vector<LoadDirection> all = branches(campaign_);
    Factor factor = by_text("branch", [&all](std::size_t i) -> std::string {
      if (all[i] == LoadDirection::unstated) return {};
      return all[i] == LoadDirection::loading ? "loading" : "unloading";
    });
    factor.along_load = true;
    return factor;
  }

  std::vector<double> session_starts() const {
    std::vector<double> start(campaign_.sessions.size(), std::numeric_limits<double>::infinity());
    for (const Reading& r : campaign_.readings)
      if (r.time) start[r.session] = std::min(start[r.session], *r.time);
    return start;
  }

  bool sessions_start_apart() const { return distinct_values(session_starts()).size() > 1; }

  // What drifts may begin anew with every session.
  Factor time_in_session() const {
    const std::vector<double> start = session_starts();
    return by_number("time in the session", campaign_.units.time, [&start](const Reading& r) {
      return r.time ? std::optional(*r.time - start[r.session]) : std::nullopt;
    });
  }

  Factor sessions() const {
    return by_text("session",
                   [this](std::size_t i) { return campaign_.sessions[reading(i).session]; });
  }
  Factor settings() const {
    return by_text("setting", [this](std::size_t i) { return reading(i).setting; });
  }

  Factor covariate(const Covariate& c) const {
    const auto index = [this](const Reading& r) {
      return static_cast<std::size_t>(&r - campaign_.readings.data());
    };
    const auto number = [&](const Reading& r) -> std::optional<double> {
      const std::string& text = c.values[index(r)];
      double value = 0;
      const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
      if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
        return std::nullopt;
      return value;
    };
    const bool numeric = std::all_of(
        campaign_.readings.begin(), campaign_.readings.end(),
        [&](const Reading& r) { return c.values[index(r)].empty() || number(r).has_value(); });
    if (numeric) return by_number(c.name, "", number);
    return by_text(c.name, [&c](std::size_t i) { return c.values[i]; });
  }

  void add(const Factor& factor, Patterns& result) const {
    std::vector<Sample> samples;
    for (const Sample& s : factor.along_load ? along_load_ : components_)
      if (factor.group[s.reading] >= 0) samples.push_back(s);
    Pattern pattern{.factor = factor.name, .along_load = factor.along_load};
    pattern.groups = groups(factor, samples);
    if (!factor.along_load) add_components(factor, samples, pattern.groups);
    if (pattern.groups.size() < 2) return;
    std::vector<Sample> sizes = samples;
    for (Sample& s : sizes) s.value = std::sqrt(std::abs(s.value));
    pattern.is_trend = !factor.number.empty();
    const auto explained = [&](const std::vector<Sample>& all) {
      return pattern.is_trend ? along_line(all, factor.number) : between_groups(all, factor.group);
    };
    pattern.bias = test_of(explained(samples), parameters_);
    pattern.size = test_of(explained(sizes), parameters_);
    result.factors.push_back(std::move(pattern));
  }

  // Which component holds most of the error of each group.
  static void add_components(const Factor& factor, const std::vector<Sample>& samples,
                             std::vector<PatternGroup>& groups) {
    std::map<std::string, std::array<double, 6>> squares;
    for (const Sample& s : samples)
      squares[factor.labels[static_cast<std::size_t>(factor.group[s.reading])]][s.channel] +=
          s.value * s.value;
    for (PatternGroup& group : groups) {
      const std::array<double, 6>& all = squares[group.label];
      const double total = std::accumulate(all.begin(), all.end(), 0.0);
      // The first of equals, whatever rounding makes of them.
      const double largest = *std::max_element(all.begin(), all.end());
      const auto most = std::find_if(all.begin(), all.end(),
                                     [largest](double x) { return x >= (1 - rounding) * largest; });
      if (!(total > 0)) continue;
      group.component = static_cast<Index>(most - all.begin());
      group.component_share = largest / total;
    }
  }

  static std::vector<PatternGroup> groups(const Factor& factor,
                                          const std::vector<Sample>& samples) {
    std::vector<PatternGroup> all(factor.labels.size());
    double total = 0;
    for (const Sample& s : samples) {
      PatternGroup& group = all[static_cast<std::size_t>(factor.group[s.reading])];
      ++group.values;
      group.share += s.value * s.value;
      group.mean += s.value;
      total += s.value * s.value;
    }
    std::vector<PatternGroup> result;
    for (std::size_t g = 0; g < all.size(); ++g) {
      if (all[g].values == 0) continue;
      all[g].label = factor.labels[g];
      all[g].mean /= static_cast<double>(all[g].values);
      all[g].share_of_values =
          static_cast<double>(all[g].values) / static_cast<double>(samples.size());
      if (total > 0) all[g].share /= total;
      result.push_back(all[g]);
    }
    std::stable_sort(
        result.begin(), result.end(),
        [](const PatternGroup& a, const PatternGroup& b) { return a.share > b.share; });
    return result;
  }

  std::optional<Reversal> reversal() const {
    Reversal result;
    double odd = 0, even = 0;
    Index values = 0;
    for (const auto& [a, b] : reversed_pairs(campaign_)) {
      ++result.pairs;
      for (Index k = 0; k < 6; ++k) {
        if (!reading(a).uses(k) || !reading(b).uses(k)) continue;
        if (!noise_.comparable && is_rotation(k)) continue;
        odd += std::pow(whitened_[a][k] - whitened_[b][k], 2);
        even += std::pow(whitened_[a][k] + whitened_[b][k], 2);
        ++values;
      }
    }
    const double smaller = std::min(odd, even);
    if (values == 0 || !(smaller > 0)) return std::nullopt;
    result.odd_share = odd / (odd + even);
    result.test.degrees_of_freedom = result.test.degrees_of_freedom_within = values;
    result.test.f = std::max(odd, even) / smaller;
    result.test.p_value = std::min(1.0, 2 * p_of_f(result.test.f, values, values));
    return result;
  }

  std::vector<Loop> loops() {
    std::vector<Loop> result;
    for (const Cycle& cycle : load_cycles(campaign_)) {
      if (!is_closed(cycle)) continue;
      Loop loop{.session = campaign_.sessions[reading(cycle[0]).session],
                .cycle = reading(cycle[0]).cycle};
      add_area(cycle, loop);
      add_return(cycle, loop);
      result.push_back(std::move(loop));
    }
    return result;
  }

  bool is_closed(const Cycle& cycle) const {
    if (cycle.size() < 3) return false;
    double size = 0;
    for (const std::size_t i : cycle) {
      if (reading(i).configuration != reading(cycle[0]).configuration) return false;
      size = std::max(size, level_of(reading(i).load));
    }
    // Predictions follow the same loads, so that a gap between both ends hardly matters.
    const vjm::Load &first = reading(cycle.front()).load, &last = reading(cycle.back()).load;
    const vjm::Load gap{.force = first.force - last.force, .moment = first.moment - last.moment};
    return size > 0 && level_of(gap) <= same_load * size;
  }

  // Trapezoidal rule of the integral of the load over the displacement, in measured components.
  // It is linear in the readings, so their noise carries over with the coefficients.
  void add_area(const Cycle& cycle, Loop& loop) {
    double variance = 0;
    for (Index k = 0; k < 6; ++k) {
      if (!std::all_of(cycle.begin(), cycle.end(),
                       [&](std::size_t i) { return reading(i).uses(k); }))
        continue;
      const auto load = [&](std::size_t n) { return work_[cycle[n]][k]; };
      for (std::size_t n = 0; n < cycle.size(); ++n) {
        const std::size_t i = cycle[n];
        const double before = n > 0 ? load(n - 1) + load(n) : 0;
        const double after = n + 1 < cycle.size() ? load(n) + load(n + 1) : 0;
        const double coefficient = (before - after) / 2;
        loop.measured += coefficient * reading(i).displacement[k];
        loop.predicted += coefficient * (reading(i).displacement[k] - residual_[i][k]);
        variance += std::pow(coefficient * noise_.sigma[i][k], 2);
      }
    }
    if (noise_.source == NoiseSource::unknown) return;
    loop.noise = std::sqrt(variance);
    if (variance > 0) {
      area_.sum += std::pow(loop.measured - loop.predicted, 2) / variance;
      ++area_.count;
    }
  }

  void add_return(const Cycle& cycle, Loop& loop) {
    std::optional<std::size_t> first, last;
    double size = 0;
    for (const std::size_t i : cycle) size = std::max(size, level_of(reading(i).load));
    for (const std::size_t i : cycle)
      if (level_of(reading(i).load) <= same_load * size) (first ? last : first) = i;
    if (!last) return;
    loop.return_to_zero = residual_[*last] - residual_[*first];
    if (noise_.source == NoiseSource::unknown) return;
    for (Index k = 0; k < 6; ++k) {
      if (!reading(*first).uses(k) || !reading(*last).uses(k)) continue;
      return_.sum += std::pow((*loop.return_to_zero)[k], 2) /
                     (std::pow(noise_.sigma[*first][k], 2) + std::pow(noise_.sigma[*last][k], 2));
      ++return_.count;
    }
  }

  // A sum of squares over the noise.
  struct Squares {
    double sum = 0;
    Index count = 0;
  };

  std::optional<LoopTest> loop_test(const Squares& squares) const {
    if (squares.count == 0) return std::nullopt;
    LoopTest test{.statistic = squares.sum,
                  .degrees_of_freedom = squares.count,
                  .degrees_of_freedom_noise = noise_.degrees_of_freedom};
    const auto n = static_cast<double>(squares.count);
    if (noise_.degrees_of_freedom > 0) {
      test.p_value = p_of_f(squares.sum / n, squares.count, noise_.degrees_of_freedom);
    } else {
      const boost::math::chi_squared law(n);
      test.p_value = boost::math::cdf(boost::math::complement(law, squares.sum));
    }
    return test;
  }

  void correct(Patterns& patterns) const {
    std::vector<std::pair<double, double*>> tests;  // p-value and where its correction belongs
    const auto add = [&tests](auto& test) {
      if (test) tests.emplace_back(test->p_value, &test->holm_p_value);
    };
    for (Pattern& pattern : patterns.factors) add(pattern.bias), add(pattern.size);
    if (patterns.reversal)
      tests.emplace_back(patterns.reversal->test.p_value, &patterns.reversal->test.holm_p_value);
    add(patterns.loop_area);
    add(patterns.return_to_zero);
    std::vector<double> p;
    for (const auto& test : tests) p.push_back(test.first);
    const std::vector<double> adjusted = holm(p);
    for (std::size_t i = 0; i < tests.size(); ++i) *tests[i].second = adjusted[i];
    std::stable_sort(
        patterns.factors.begin(), patterns.factors.end(),
        [](const Pattern& a, const Pattern& b) { return a.holm_p_value() < b.holm_p_value(); });
  }

  const Campaign& campaign_;
  const std::vector<Vector6>& residual_;
  const std::vector<Vector6>& whitened_;
  const std::vector<Vector6>& work_;
  Index parameters_;
  const Noise& noise_;
  std::vector<Sample> components_, along_load_;
  Squares area_, return_;
};

}  // namespace

double Pattern::holm_p_value() const {
  return std::min(bias ? bias->holm_p_value : 1.0, size ? size->holm_p_value : 1.0);
}

std::vector<double> holm(const std::vector<double>& p_values) {
  std::vector<std::size_t> order(p_values.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return p_values[a] < p_values[b]; });
  std::vector<double> adjusted(p_values.size());
  double largest = 0;
  for (std::size_t rank = 0; rank < order.size(); ++rank) {
    const auto left = static_cast<double>(order.size() - rank);
    largest = std::max(largest, std::min(1.0, left * p_values[order[rank]]));
    adjusted[order[rank]] = largest;
  }
  return adjusted;
}

Patterns find_patterns(const Campaign& campaign, const std::vector<Vector6>& residual,
                       const std::vector<Vector6>& whitened, const std::vector<Vector6>& work,
                       Index parameters, const Noise& noise) {
  return Finder(campaign, residual, whitened, work, parameters, noise).find();
}

}  // namespace kinetostat::calibration
