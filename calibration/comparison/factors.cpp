#include "kinetostat/calibration/comparison/factors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include <fmt/format.h>

#include "kinetostat/calibration/campaign/load_history.h"

namespace kinetostat::calibration {
namespace {

using Eigen::Index;
using spatial::Vector6;

constexpr double rounding_of_direction = 1e-9;

class FactorFinder {
 public:
  explicit FactorFinder(const Campaign& campaign)
      : campaign_(campaign), changing_(changing_loads(campaign)) {}

  std::vector<Factor> all() const {
    std::vector<Factor> factors = {postures(), reach(),         load_directions(),
                                   levels(),   load_branches(), sessions()};
    factors.push_back(
        by_number("time", campaign_.units.time, [](const Reading& r) { return r.time; }));
    if (sessions_start_apart()) factors.push_back(time_in_session());
    factors.push_back(by_number("temperature", "", [](const Reading& r) { return r.temperature; }));
    factors.push_back(settings());
    for (const Covariate& c : campaign_.covariates) factors.push_back(covariate(c));
    return factors;
  }

 private:
  const Reading& reading(std::size_t i) const { return campaign_.readings[i]; }

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
      const std::string from = fmt::format("{:.4g}", values[first] / scale);
      const std::string to = fmt::format("{:.4g}", values[last] / scale);
      factor.labels.push_back(fmt::format("{}{}{}{}{}", from, from == to ? "" : " to ",
                                          from == to ? "" : to, unit.empty() ? "" : " ", unit));
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
    for (const auto& [joint, value] : c.joints) {
      const bool turns = campaign_.joint_columns.at(joint).turns;
      const std::string& name = turns ? campaign_.units.angle : campaign_.units.length;
      label += fmt::format("{}{} = {:.4g} {}", label.empty() ? "" : ", ", joint,
                           value / spatial::parse_unit(name).factor, name);
    }
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
      const Vector6 u = direction_of(changing_[i]);
      for (Index k = 0; k < 6; ++k)  // the first of equals, whatever rounding makes of them
        if (!u.isZero(0) && std::abs(u[k]) >= u.cwiseAbs().maxCoeff() - rounding_of_direction)
          return fmt::format(
              "{}{}", u[k] > 0 ? "+" : "-",
              std::array{"fx", "fy", "fz", "mx", "my", "mz"}[static_cast<std::size_t>(k)]);
      return {};
    });
  }

  // Forces only, or moments where there is no force at all: they have no common scale.
  Factor levels() const {
    const bool forces = std::any_of(changing_.begin(), changing_.end(),
                                    [](const vjm::Load& load) { return !load.force.isZero(0); });
    const std::string unit =
        forces ? campaign_.units.force : campaign_.units.force + " " + campaign_.units.length;
    Factor factor = by_number("level of load", unit, [&](const Reading& r) {
      const vjm::Load& load = changing_[static_cast<std::size_t>(&r - campaign_.readings.data())];
      const bool has = forces ? !load.force.isZero(0) : !load.moment.isZero(0);
      return has ? std::optional(level_of(load)) : std::nullopt;
    });
    factor.number.clear();  // a curve, not a line
    factor.along_load = true;
    return factor;
  }

  Factor load_branches() const {
    const std::vector<LoadDirection> all = branches(campaign_, changing_);
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

  // What drifts may start anew with every session.
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
    if (c.is_numeric())
      return by_number(c.name, "", [&](const Reading& r) { return c.number(index(r)); });
    return by_text(c.name, [&c](std::size_t i) { return c.values[i]; });
  }

  const Campaign& campaign_;
  std::vector<vjm::Load> changing_;
};

}  // namespace

std::vector<Factor> factors_of(const Campaign& campaign) { return FactorFinder(campaign).all(); }

}  // namespace kinetostat::calibration
