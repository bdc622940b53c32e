// Confounders: the nearest ones that the catalogue names are computed.
#include <algorithm>
#include <map>
#include <set>

#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include "kinetostat/calibration/regression/reading_offsets.h"
#include "kinetostat/calibration/search/candidate_fitter.h"

#include "calibration/synthetic.h"
#include "vjm/effect_catalogue.h"

namespace kinetostat::calibration::effect_confuser_test {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using vjm::test::Bench;

// Two postures, three directions, up, down and reversed; time and temperature go their own ways.
Campaign plan_for(const Bench& bench, bool arm, DisplacementKind displacement) {
  Campaign campaign;
  campaign.displacement = displacement;
  campaign.file = campaign.readings_file = "plan";
  campaign.noise_stated = true;
  campaign.sessions = {""};
  campaign.configurations.resize(2);
  if (arm) {
    campaign.configurations[0].joints = {{"carousel.q1", 0.3}, {"arm.q3", -0.1}, {"arm.q5", 0.8}};
    campaign.configurations[1].joints = {{"carousel.q1", -0.3}, {"arm.q3", -0.6}, {"arm.q5", 0.2}};
  } else {
    campaign.configurations[0].target = spatial::Pose::translation({0.05, 0.04, -0.03});
    campaign.configurations[1].target = spatial::Pose::translation({-0.06, 0.03, 0.05});
  }
  for (Eigen::Index axis = 0; axis < 3; ++axis)
    for (std::size_t pose = 0; pose < 2; ++pose)
      for (const double level : {0.5, 1.0, -1.0, 0.0}) {
        const auto n = static_cast<double>(campaign.readings.size());
        Reading reading;
        reading.id = fmt::format("{}", n);
        reading.cycle = fmt::format("{}{}", pose, axis);
        reading.step = n;
        reading.time = 90 * n;
        reading.temperature = 21 + 4 * std::sin(2.4 * n);
        reading.configuration = pose;
        reading.load.force = bench.force * level * spatial::Vector3::Unit(axis);
        reading.displacement.setZero();
        reading.sigma << 1e-6, 1e-6, 1e-6, 3e-6, 3e-6, 3e-6;
        campaign.readings.push_back(reading);
      }
  return campaign;
}

// Signatures in units of the noise beside the model without effects, by the readings of one plan.
class Signatures {
 public:
  Signatures(const Bench& bench, bool arm, DisplacementKind kind)
      : robot_{.file = "bench",
               .name = bench.name,
               .units = {},
               .manipulator = bench.manipulator,
               .uncertain = {},
               .link_files = {}},
        campaign_(plan_for(bench, arm, kind)),
        values_(values_in_use(campaign_)) {
    plain_ = predicted({});
    std::set<std::string> places = {"load", "sensor", "platform", "end", "base"};
    for (const vjm::Effect& effect : bench.effects) places.insert(effect.at);
    for (const Candidate& candidate : candidates(robot_, {}))
      if (places.contains(candidate.effect.at))
        for (const vjm::Effect& effect : somewhere(candidate.effect))
          spans_[effect.kind->name].push_back(span_of_candidate(effect));
  }

  VectorXd signature(const vjm::Effect& effect) const { return predicted({effect}) - plain_; }

  // How much of a signature each other kind can make, at its best place; largest first.
  std::vector<std::pair<double, std::string>> confounders(const vjm::Effect& effect) const {
    const VectorXd own = signature(effect).normalized();
    std::vector<std::pair<double, std::string>> all;
    for (const auto& [kind, spans] : spans_) {
      if (kind == effect.kind->name) continue;
      double largest = 0;
      for (const MatrixXd& span : spans)
        largest = std::max(largest, (span.transpose() * own).norm());
      all.emplace_back(largest, kind);
    }
    std::sort(all.rbegin(), all.rend());
    return all;
  }

 private:
  VectorXd predicted(const std::vector<vjm::Effect>& effects) const {
    common::Progress silent;
    const Predictions p = Predictor(robot_.manipulator, effects, campaign_, 1, silent)
                              .predict({}, VectorXd(), false, silent);
    VectorXd result = VectorXd::Constant(static_cast<Eigen::Index>(values_.size()), std::nan(""));
    if (p.failure) return result;
    for (std::size_t v = 0; v < values_.size(); ++v)
      result[static_cast<Eigen::Index>(v)] =
          p.displacement[values_[v].reading][values_[v].component] /
          campaign_.readings[values_[v].reading].sigma[values_[v].component];
    return result;
  }

  // Of readings here and there, where it is of some only.
  std::vector<vjm::Effect> somewhere(const vjm::Effect& effect) const {
    if (!effect.kind->offsets_readings) return {effect};
    std::vector<vjm::Effect> some;
    const std::vector<vjm::Effect> all = placements(effect, campaign_, {});
    const std::size_t every = 1 + all.size() / 6;
    for (std::size_t i = every / 2; i < all.size(); i += every) some.push_back(all[i]);
    return some;
  }

  // Of its usual size, and of each value that may be left out by itself.
  MatrixXd span_of_candidate(const vjm::Effect& effect) const {
    std::vector<VectorXd> columns = {signature(effect)};
    for (Eigen::Index k = 1; k < effect.values.size(); ++k) {
      const vjm::EffectParameter& p = effect.kind->parameters[static_cast<std::size_t>(k)];
      if (p.required) continue;
      vjm::Effect alone = effect;
      alone.values[k] = std::clamp(
          effect.values[k] + vjm::prior_deviation(effect, k, robot_.manipulator), p.lower, p.upper);
      try {
        columns.push_back(signature(alone) - columns[0]);
      } catch (const std::invalid_argument&) {
        continue;  // a bearing does not yield along a joint that slides
      }
    }
    MatrixXd matrix(columns[0].size(), 0);
    for (const VectorXd& column : columns) {
      if (!column.allFinite()) continue;
      matrix.conservativeResize(Eigen::NoChange, matrix.cols() + 1);
      matrix.rightCols<1>() = column;
    }
    return span_of(matrix, least_visible);
  }

  vjm::Robot robot_;
  Campaign campaign_;
  std::vector<Value> values_;
  VectorXd plain_;
  std::map<std::string, std::vector<MatrixXd>> spans_;
};

// Kinds of the catalogue that a text names.
std::vector<std::string> kinds_in(const std::string& text) {
  std::vector<std::string> names;
  for (const auto& kind : vjm::effect_kinds())
    for (std::size_t at = text.find(kind->name); at != std::string::npos;
         at = text.find(kind->name, at + 1)) {
      const bool whole = (at == 0 || text[at - 1] != '_') &&
                         text.substr(at + kind->name.size(), 1).find_first_of("_") != 0;
      if (whole) {
        names.push_back(kind->name);
        break;
      }
    }
  return names;
}

// On one robot at least, a named confounder makes at least 90 % of what the nearest of all makes.
TEST(EffectConfounder, TheCatalogueNamesTheNearestOne) {
  std::map<std::string, double> best;        // of the named ones, over the nearest of all
  std::map<std::string, std::string> found;  // for the documentation
  for (const bool arm : {false, true}) {
    const Bench bench = arm ? vjm::test::arm_bench() : vjm::test::parallel_bench();
    const Signatures difference(bench, arm, DisplacementKind::difference);
    const Signatures absolute(bench, arm, DisplacementKind::absolute);
    for (const vjm::Effect& effect : bench.effects) {
      const std::string& name = effect.kind->name;
      const auto all =
          (vjm::test::displaces_without_load(name) ? absolute : difference).confounders(effect);
      const std::vector<std::string> named = kinds_in(effect.kind->confuser);
      EXPECT_FALSE(named.empty()) << name << ": " << effect.kind->confuser;
      for (const auto& [cosine, kind] : all)
        if (std::find(named.begin(), named.end(), kind) != named.end())
          best[name] = std::max(best[name], cosine / all[0].first);
      found[name] += fmt::format("; {} at {}: {} {:.2f}, {} {:.2f}, {} {:.2f}", bench.name,
                                 effect.at, all[0].second, all[0].first, all[1].second,
                                 all[1].first, all[2].second, all[2].first);
    }
  }
  for (const auto& [name, text] : found) {
    EXPECT_GT(best[name], 0.9) << name << " names '" << vjm::effect_kind(name)->confuser << "'"
                               << text;
    RecordProperty(name, text.substr(2));
  }
}

}  // namespace
}  // namespace kinetostat::calibration::effect_confuser_test
