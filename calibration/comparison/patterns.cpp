#include "kinetostat/calibration/comparison/patterns.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>

#include "kinetostat/calibration/campaign/load_history.h"
#include "kinetostat/calibration/comparison/factors.h"
#include "kinetostat/calibration/statistics/goodness_of_fit.h"

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
  test.p_value = chance_of_larger_f(test.f, static_cast<double>(e.degrees_of_freedom),
                                    static_cast<double>(within));
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

class PatternFinder {
 public:
  PatternFinder(const Campaign& campaign, const std::vector<Eigen::VectorXd>& residual,
                const std::vector<Eigen::VectorXd>& whitened, const std::vector<Vector6>& work,
                Index parameters, const Noise& noise)
      : campaign_(campaign),
        residual_(residual),
        whitened_(whitened),
        work_(work),
        parameters_(parameters),
        noise_(noise) {
    for (std::size_t i = 0; i < campaign.readings.size(); ++i)
      for (const Index k : components_in_use(campaign.readings[i]))
        if (counts(k)) components_.push_back({i, static_cast<std::size_t>(k), whitened[i][k]});
    find_along_load();
  }

  Patterns find() {
    Patterns result;
    if (is_rounding()) return result;
    for (const Factor& factor : factors_of(campaign_)) add(factor, result);
    result.reversal = reversal();
    result.loops = find_loops(campaign_, residual_, work_, noise_);
    correct(result);
    return result;
  }

 private:
  const Reading& reading(std::size_t i) const { return campaign_.readings[i]; }

  // Where nothing says how kinds of components compare, those of the first kind.
  bool counts(Index k) const {
    if (noise_.comparable) return true;
    for (const std::vector<Index>& kind : component_kinds(campaign_))
      if (std::any_of(campaign_.readings.begin(), campaign_.readings.end(), [&](const Reading& r) {
            return std::any_of(kind.begin(), kind.end(), [&](Index c) { return r.uses(c); });
          }))
        return std::find(kind.begin(), kind.end(), k) != kind.end();
    return true;
  }

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
      for (const Index k : components_in_use(reading(i))) {
        if (!campaign_.is_of_platform(k)) continue;
        const double along = u[campaign_.component(k).axis];
        sum += along * whitened_[i][k], squares += along * along;
      }
      // Less than this share of the load's direction is measured: it tells nothing.
      if (squares > 1e-6) along_load_.push_back({i, 0, sum / std::sqrt(squares)});
    }
  }

  // Direction of the load in the axes of the displacements.
  Vector6 direction_seen(std::size_t i) const {
    const Vector6& w = work_[i];
    return direction_of({.force = w.head<3>(), .moment = w.tail<3>()});
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
  void add_components(const Factor& factor, const std::vector<Sample>& samples,
                      std::vector<PatternGroup>& groups) const {
    std::map<std::string, std::vector<double>> squares;
    for (const std::string& label : factor.labels)
      squares[label].resize(campaign_.components.size());
    for (const Sample& s : samples)
      squares[factor.labels[static_cast<std::size_t>(factor.group[s.reading])]][s.channel] +=
          s.value * s.value;
    for (PatternGroup& group : groups) {
      const std::vector<double>& all = squares[group.label];
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
      for (Index k = 0; k < campaign_.size(); ++k) {
        if (!reading(a).uses(k) || !reading(b).uses(k) || !counts(k)) continue;
        odd += std::pow(whitened_[a][k] - whitened_[b][k], 2);
        even += std::pow(whitened_[a][k] + whitened_[b][k], 2);
        ++values;
      }
    }
    const auto n = static_cast<double>(values);
    const double smaller = std::min(odd, even);
    if (values == 0 || !(smaller > 0)) return std::nullopt;
    result.odd_share = odd / (odd + even);
    result.test.degrees_of_freedom = result.test.degrees_of_freedom_within = values;
    result.test.f = std::max(odd, even) / smaller;
    result.test.p_value = std::min(1.0, 2 * chance_of_larger_f(result.test.f, n, n));
    return result;
  }

  void correct(Patterns& patterns) const {
    std::vector<std::pair<double, double*>> tests;  // p-value and where its correction belongs
    const auto add = [&tests](auto& test) {
      if (test) tests.emplace_back(test->p_value, &test->holm_p_value);
    };
    for (Pattern& pattern : patterns.factors) add(pattern.bias), add(pattern.size);
    if (patterns.reversal)
      tests.emplace_back(patterns.reversal->test.p_value, &patterns.reversal->test.holm_p_value);
    add(patterns.loops.area);
    add(patterns.loops.return_to_zero);
    std::vector<double> p;
    p.reserve(tests.size());
    for (const auto& test : tests) p.push_back(test.first);
    const std::vector<double> adjusted = holm(p);
    for (std::size_t i = 0; i < tests.size(); ++i) *tests[i].second = adjusted[i];
    std::stable_sort(
        patterns.factors.begin(), patterns.factors.end(),
        [](const Pattern& a, const Pattern& b) { return a.holm_p_value() < b.holm_p_value(); });
  }

  const Campaign& campaign_;
  const std::vector<Eigen::VectorXd>& residual_;
  const std::vector<Eigen::VectorXd>& whitened_;
  const std::vector<Vector6>& work_;
  Index parameters_;
  const Noise& noise_;
  std::vector<Sample> components_, along_load_;
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

Patterns find_patterns(const Campaign& campaign, const std::vector<Eigen::VectorXd>& residual,
                       const std::vector<Eigen::VectorXd>& whitened,
                       const std::vector<Vector6>& work, Index parameters, const Noise& noise) {
  return PatternFinder(campaign, residual, whitened, work, parameters, noise).find();
}

}  // namespace kinetostat::calibration
