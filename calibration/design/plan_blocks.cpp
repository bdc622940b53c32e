#include "kinetostat/calibration/design/plan_blocks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <tuple>

#include <fmt/format.h>

#include "kinetostat/calibration/campaign/load_history.h"
#include "kinetostat/common/parallel.h"
#include "kinetostat/vjm/manipulator/joint_range.h"
#include "kinetostat/vjm/manipulator/posture.h"
#include "kinetostat/vjm/statics/equilibrium.h"

namespace kinetostat::calibration {
namespace {

using spatial::Vector3;
using spatial::Vector6;

constexpr std::size_t most_used = 10;  // postures of the campaign that are tried again
constexpr std::size_t most_new = 8;    // that it did not have

bool is_one_sided(const LoadPattern& pattern) {
  return std::none_of(pattern.steps.begin(), pattern.steps.end(),
                      [](const CycleStep& step) { return step.level < 0; });
}

double minutes_of(const LoadPattern& pattern, const MeasuringOptions& options) {
  double minutes = 0, level = 0;
  for (const CycleStep& step : pattern.steps) {
    minutes += options.minutes_per_reading + step.held * options.hold;
    if (step.level != level) minutes += options.minutes_per_load;
    level = step.level;
  }
  return minutes;
}

// The coordinates of a configuration in which others may be sought, one entry a name.
std::map<std::string, double> coordinates_of(const Configuration& configuration) {
  std::map<std::string, double> result = configuration.joints;
  if (configuration.target)
    for (const auto& [name, axis] : {std::pair("x", 0), {"y", 1}, {"z", 2}})
      result[name] = configuration.target->position()[axis];
  return result;
}

Configuration moved_to(Configuration configuration, const std::map<std::string, double>& where) {
  if (configuration.target)
    configuration.target = spatial::Pose(configuration.target->rotation(),
                                         Vector3(where.at("x"), where.at("y"), where.at("z")));
  else
    configuration.joints = where;
  return configuration;
}

// Evenly scattered numbers in [0, 1] (van der Corput 1935, in one base a coordinate).
double scattered(std::size_t index, std::size_t coordinate) {
  static constexpr std::size_t primes[] = {2, 3, 5, 7, 11, 13, 17, 19};
  const std::size_t base = primes[coordinate % std::size(primes)];
  double value = 0, share = 1;
  for (std::size_t i = index; i > 0; i /= base) {
    share /= static_cast<double>(base);
    value += share * static_cast<double>(i % base);
  }
  return value;
}

using Span = std::array<double, 2>;

std::vector<std::size_t> used_configurations(const Campaign& campaign) {
  std::set<std::size_t> used;
  for (const Reading& reading : campaign.readings)
    if (is_used(reading)) used.insert(reading.configuration);
  return {used.begin(), used.end()};
}

// Least and largest value of each coordinate in a campaign.
std::map<std::string, Span> spans_of(const Campaign& campaign,
                                     const std::vector<std::size_t>& used) {
  std::map<std::string, Span> spans;
  for (const std::size_t i : used)
    for (const auto& [name, value] : coordinates_of(campaign.configurations[i])) {
      Span& span = spans.try_emplace(name, Span{value, value}).first->second;
      span = {std::min(span[0], value), std::max(span[1], value)};
    }
  return spans;
}

// Those of the campaign, evenly thinned out.
std::vector<Configuration> thinned_out(const Campaign& campaign,
                                       const std::vector<std::size_t>& used) {
  std::vector<Configuration> result;
  const std::size_t count = std::min(used.size(), most_used);
  for (std::size_t i = 0; i < count; ++i)
    result.push_back(campaign.configurations[used[i * used.size() / count]]);
  return result;
}

// Others, scattered in the space that they span.
std::vector<Configuration> scattered_like(const Configuration& first,
                                          const std::map<std::string, Span>& spans) {
  std::vector<Configuration> result;
  const bool moves = std::any_of(spans.begin(), spans.end(), [](const auto& entry) {
    return entry.second[1] > entry.second[0];
  });
  for (std::size_t n = 1; moves && n <= most_new; ++n) {
    std::map<std::string, double> where;
    std::size_t coordinate = 0;
    for (const auto& [name, span] : spans)
      where[name] = span[0] + scattered(n, coordinate++) * (span[1] - span[0]);
    result.push_back(moved_to(first, where));
  }
  return result;
}

// One joint alone, turned through its range.
std::vector<Configuration> swept(const Configuration& first, const std::string& joint, Span span) {
  constexpr int steps = 6;
  std::vector<Configuration> result;
  for (int i = 0; i <= steps; ++i) {
    Configuration& now = result.emplace_back(first);
    now.joints[joint] = span[0] + (span[1] - span[0]) * i / steps;
  }
  return result;
}

// Where a joint may go: by what was asked for, the robot file, or what the campaign had.
Span range_of(const std::string& joint, const vjm::Manipulator& manipulator,
              const MeasuringOptions& options, Span in_campaign) {
  if (const auto given = options.within.find(joint); given != options.within.end())
    return given->second;
  for (const vjm::Chain& chain : manipulator.chains())
    for (const vjm::Coordinate& c : chain.coordinates())
      if (chain.name() + "." + c.name == joint && c.range) return *c.range;
  return in_campaign;
}

/// Postures to choose from; those from `first_swept` on are read without load only.
struct Postures {
  std::vector<Configuration> all;
  std::size_t first_swept = 0;
};

Postures postures_to_try(const vjm::Manipulator& manipulator, const Campaign& campaign,
                         const PlanPlaces& places, const MeasuringOptions& options) {
  const std::vector<std::size_t> used = used_configurations(campaign);
  Postures result;
  if (used.empty()) return result;
  const Configuration& first = campaign.configurations[used.front()];
  result.all = thinned_out(campaign, used);
  std::map<std::string, Span> spans = spans_of(campaign, used);
  std::map<std::string, Span> wider = spans;
  for (auto& [name, span] : wider)
    if (const auto given = options.within.find(name); given != options.within.end())
      span = given->second;
  for (Configuration& other : scattered_like(first, wider)) result.all.push_back(std::move(other));
  if (first.target)
    for (const spatial::Pose& pose : places.work_at)
      result.all.push_back({.target = pose, .joints = {}});
  result.first_swept = result.all.size();
  for (const std::string& joint : places.joints) {
    const auto span = spans.find(joint);
    if (first.target || span == spans.end()) continue;
    const Span range = range_of(joint, manipulator, options, span->second);
    if (range[0] < range[1])
      for (Configuration& other : swept(first, joint, range))
        result.all.push_back(std::move(other));
  }
  return result;
}

// Loads that are tried: along each axis, as large as the campaign had or the user allows.
std::vector<std::pair<std::string, Vector6>> loads_to_try(const Campaign& campaign,
                                                          const MeasuringOptions& options) {
  double force = options.most_force, moment = options.most_moment;
  double largest_force = 0, largest_moment = 0;
  for (const Reading& reading : campaign.readings) {
    if (!is_used(reading)) continue;
    largest_force = std::max(largest_force, reading.load.force.norm());
    largest_moment = std::max(largest_moment, reading.load.moment.norm());
  }
  if (!(force > 0)) force = largest_force;
  if (!(moment > 0)) moment = largest_moment;
  std::vector<std::pair<std::string, Vector6>> loads;
  static constexpr const char* names[] = {"fx", "fy", "fz", "mx", "my", "mz"};
  for (Eigen::Index k = 0; k < 6; ++k) {
    const double size = k < 3 ? force : moment;
    if (size > 0) loads.emplace_back(names[k], size * Vector6::Unit(k));
  }
  return loads;
}

// Where most loads of the campaign act; of equals the first.
spatial::Vector3 usual_point(const Campaign& campaign) {
  std::vector<std::pair<spatial::Vector3, int>> points;
  for (const Reading& reading : campaign.readings) {
    if (!is_used(reading) || level_of(reading.load) == 0) continue;
    const auto known = std::find_if(points.begin(), points.end(), [&](const auto& point) {
      return point.first == reading.load.point_on_platform;
    });
    if (known == points.end())
      points.emplace_back(reading.load.point_on_platform, 1);
    else
      ++known->second;
  }
  const auto most =
      std::max_element(points.begin(), points.end(),
                       [](const auto& a, const auto& b) { return a.second < b.second; });
  return most == points.end() ? spatial::Vector3::Zero().eval() : most->first;
}

vjm::Load load_of(const Vector6& wrench, const spatial::Vector3& point) {
  return {.force = wrench.head<3>(), .moment = wrench.tail<3>(), .point_on_platform = point};
}

vjm::PostureResult posture_of(const vjm::Manipulator& manipulator,
                              const Configuration& configuration) {
  if (configuration.target) return vjm::posture_at(manipulator, *configuration.target);
  return vjm::posture_from_joints(manipulator, configuration.joints);
}

bool is_borne(const vjm::Manipulator& manipulator, const vjm::Posture& posture,
              const vjm::Load& load) {
  const vjm::Equilibrium e = vjm::equilibrium_under_load(manipulator, posture, load);
  return e.status == vjm::EquilibriumStatus::converged && e.free.stable();
}

std::string place_text(const Configuration& configuration) {
  std::string text;
  for (const auto& [name, value] : coordinates_of(configuration))
    text += fmt::format("{}{} = {:.4g}", text.empty() ? "" : ", ", name, value);
  return text.empty() ? "home" : text;
}

}  // namespace

bool LoadPattern::takes_back() const {
  return std::adjacent_find(steps.begin(), steps.end(),
                            [](const CycleStep& before, const CycleStep& now) {
                              return std::abs(now.level) < std::abs(before.level);
                            }) != steps.end();
}

bool LoadPattern::reverses() const {
  return std::any_of(steps.begin(), steps.end(), [](const CycleStep& s) { return s.level < 0; });
}

const std::vector<LoadPattern>& load_patterns() {
  static const std::vector<LoadPattern> patterns = {
      {"up", {{0}, {0.25}, {0.5}, {0.75}, {1}}},
      {"up and down", {{0}, {0.5}, {1}, {0.5}, {0}}},
      {"reversed", {{0}, {0.5}, {1}, {0.5}, {0}, {-0.5}, {-1}, {-0.5}, {0}}},
      {"small and reversed", {{0}, {0.05}, {0.1}, {0.05}, {0}, {-0.05}, {-0.1}, {-0.05}, {0}}},
      {"held", {{0}, {1}, {1, 1}, {1, 1}, {0}, {0, 1}}},
      {"without load", {{0}}}};
  return patterns;
}

PlanChoices plan_choices(const vjm::Robot& robot, const Campaign& campaign,
                         const PlanPlaces& places, const MeasuringOptions& options, int threads,
                         common::Progress& progress) {
  PlanChoices choices;
  const Postures postures = postures_to_try(robot.manipulator, campaign, places, options);
  const std::vector<Configuration>& tried = postures.all;
  const auto loads = loads_to_try(campaign, options);
  const spatial::Vector3 point = usual_point(campaign);
  // For each posture: reached, then either sign of each load borne with the margin.
  std::vector<std::vector<bool>> borne(tried.size());
  std::vector<std::string> beyond(tried.size());  // ranges of drives
  common::parallel_for(
      tried.size(), threads, "what the robot can bear", progress, [&](std::size_t i) {
        const auto posture = posture_of(robot.without_effects(), tried[i]);
        if (posture.reached)
          beyond[i] = vjm::beyond_range(robot.without_effects(), posture.posture);
        borne[i].push_back(posture.reached && beyond[i].empty());
        if (!borne[i][0] || i >= postures.first_swept) return;
        for (const auto& [name, wrench] : loads)
          for (const double sign : {options.margin, -options.margin})
            borne[i].push_back(
                is_borne(robot.manipulator, posture.posture, load_of(sign * wrench, point)));
      });
  std::map<std::string, std::size_t> refused;
  for (std::size_t i = 0; i < tried.size(); ++i) {
    if (!borne[i][0]) {
      choices.left_out.push_back("out of reach: " + place_text(tried[i]) +
                                 (beyond[i].empty() ? "" : " (" + beyond[i] + ")"));
      continue;
    }
    const std::size_t here = choices.configurations.size();
    choices.configurations.push_back(tried[i]);
    const auto add = [&](const Vector6& load, const std::string& direction,
                         const LoadPattern& pattern) {
      choices.blocks.push_back({here, load, direction, &pattern, minutes_of(pattern, options)});
    };
    add(Vector6::Zero(), "", load_patterns().back());
    for (std::size_t l = 0; i < postures.first_swept && l < loads.size(); ++l) {
      const bool plus = borne[i][1 + 2 * l], minus = borne[i][2 + 2 * l];
      if (!plus || !minus) ++refused[loads[l].first];
      for (const LoadPattern& pattern : load_patterns()) {
        if (&pattern == &load_patterns().back()) continue;
        const bool one_sided = is_one_sided(pattern);
        if (plus && (one_sided || minus)) add(loads[l].second, "+" + loads[l].first, pattern);
        if (minus && one_sided) add(-loads[l].second, "-" + loads[l].first, pattern);
      }
    }
  }
  for (const auto& [name, count] : refused)
    choices.left_out.push_back(
        fmt::format("{} at {} of {} postures: with {:g} times the load the robot has no stable "
                    "equilibrium",
                    name, count, choices.configurations.size(), options.margin));
  return choices;
}

namespace {

// What people give a block: its posture, direction and pattern.
auto identity(const PlanBlock& block) {
  return std::tuple(block.configuration, block.direction, block.pattern);
}

}  // namespace

Campaign planned_readings(const Campaign& like, DisplacementKind displacement,
                          const std::vector<Configuration>& configurations,
                          const std::vector<PlanBlock>& blocks,
                          const std::vector<Eigen::Index>& components, const Eigen::VectorXd& sigma,
                          const MeasuringOptions& options, std::optional<double> each_at) {
  Campaign campaign;
  campaign.file = campaign.readings_file = "plan";
  campaign.name = "plan";
  campaign.units = like.units;
  campaign.observation = like.observation;
  campaign.components = like.components;
  campaign.sensors = like.sensors;
  campaign.watch = like.watch;
  campaign.joint_columns = like.joint_columns;
  campaign.displacement = displacement;
  campaign.zero = like.zero;
  if (displacement == like.displacement)
    campaign.datum_noise = like.datum_noise;
  else
    campaign.datum_noise.setConstant(like.datum_noise.size(), not_a_number);
  campaign.noise_stated = true;
  campaign.sessions = {"planned"};
  campaign.configurations = configurations;
  const spatial::Vector3 point = usual_point(like);
  std::map<decltype(identity(blocks[0])), int> times_done;
  for (const PlanBlock& block : blocks) ++times_done[identity(block)];
  const bool repeats = std::any_of(times_done.begin(), times_done.end(),
                                   [](const auto& entry) { return entry.second > 1; });
  times_done.clear();
  double minutes = 0;
  std::optional<std::size_t> posture;
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    const PlanBlock& block = blocks[b];
    if (each_at && b > 0) minutes = *each_at;
    if (posture != block.configuration) minutes += options.minutes_per_pose;
    posture = block.configuration;
    const int run = ++times_done[identity(block)];
    double level = 0;
    for (std::size_t k = 0; k < block.pattern->steps.size(); ++k) {
      const CycleStep& step = block.pattern->steps[k];
      minutes += options.minutes_per_reading + step.held * options.hold +
                 (step.level != level ? options.minutes_per_load : 0);
      level = step.level;
      Reading reading;
      reading.id = fmt::format("p{}-{}", b + 1, k + 1);
      reading.cycle = fmt::format("p{}", b + 1);
      reading.step = static_cast<double>(k + 1);
      reading.time = 60 * minutes;
      if (repeats) reading.replicate = std::to_string(run);
      reading.configuration = block.configuration;
      reading.load = load_of(step.level * block.load, point);
      reading.displacement.setConstant(like.size(), std::numeric_limits<double>::quiet_NaN());
      for (const Eigen::Index c : components) reading.displacement[c] = 0;
      reading.sigma = sigma;
      campaign.readings.push_back(reading);
    }
  }
  return campaign;
}

}  // namespace kinetostat::calibration
