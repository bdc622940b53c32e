#include "kinetostat/report/readings_picture.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "kinetostat/report/manipulators/joint_motion.h"
#include "kinetostat/report/manipulators/skeleton.h"
#include "kinetostat/report/text/text.h"
#include "kinetostat/spatial/rotation.h"
#include "kinetostat/vjm/manipulator/posture.h"

namespace kinetostat::report {
namespace {

using calibration::Campaign;
using calibration::Configuration;
using calibration::Reading;
using io::Json;

// Six digits are more than a screen shows and a third of the bytes.
Json rounded(double value) {
  if (!std::isfinite(value)) return {};
  if (value == 0) return 0;
  const double scale = std::pow(10.0, 5 - std::floor(std::log10(std::abs(value))));
  return std::isfinite(scale) ? std::round(value * scale) / scale : value;
}

template <class Value>
Json column(const Campaign& campaign, const Value& value) {
  Json list = Json::array();
  for (const Reading& reading : campaign.readings) list.push_back(value(reading));
  return list;
}

// Texts as numbers into a list of the distinct ones, in the order of their first use.
class Names {
 public:
  std::size_t number(const std::string& name) {
    const auto [at, is_new] = known_.emplace(name, names_.size());
    if (is_new) names_.push_back(name);
    return at->second;
  }
  const std::vector<std::string>& names() const { return names_; }

 private:
  std::map<std::string, std::size_t> known_;
  std::vector<std::string> names_;
};

std::vector<Eigen::Index> measured(const Campaign& campaign) {
  std::vector<Eigen::Index> result;
  for (Eigen::Index k = 0; k < campaign.size(); ++k)
    if (std::any_of(campaign.readings.begin(), campaign.readings.end(),
                    [k](const Reading& r) { return !std::isnan(r.displacement[k]); }))
      result.push_back(k);
  return result;
}

// One list a component that is measured.
template <class Vectors>
Json by_component(const Campaign& campaign, const std::vector<Eigen::Index>& components,
                  const Vectors& vectors) {
  Json json = Json::object();
  for (const Eigen::Index k : components) {
    Json list = Json::array();
    for (const Eigen::VectorXd& v : vectors) list.push_back(rounded(v[k]));
    json[campaign.component(k).name] = std::move(list);
  }
  return json;
}

vjm::PostureResult posture_of(const vjm::Manipulator& manipulator,
                              const Configuration& configuration) {
  return configuration.target ? posture_at(manipulator, *configuration.target)
                              : posture_from_joints(manipulator, configuration.joints);
}

std::string label(const vjm::Robot& robot, const Configuration& configuration,
                  const vjm::PostureResult& posture) {
  const double length = spatial::parse_unit(robot.units.length).factor;
  const double angle = spatial::parse_unit(robot.units.angle).factor;
  const auto shown = [](double value) { return number(std::abs(value) < 1e-9 ? 0 : value, 4); };
  if (!configuration.target && !configuration.joints.empty()) {
    std::string text;
    for (const auto& [name, value] : configuration.joints)
      text += fmt::format("{}{} {}", text.empty() ? "" : ", ", name,
                          shown(value / (joint_turns(robot, name) ? angle : length)));
    return text;
  }
  const spatial::Vector3 p = posture.posture.platform.position() / length;
  const spatial::Vector3 r = spatial::log_rotation(posture.posture.platform.rotation()) / angle;
  std::string text =
      fmt::format("{}, {}, {} {}", shown(p.x()), shown(p.y()), shown(p.z()), robot.units.length);
  if (!r.isZero(1e-9))
    text +=
        fmt::format("; {}, {}, {} {}", shown(r.x()), shown(r.y()), shown(r.z()), robot.units.angle);
  return text;
}

Json forces_json(const Campaign& campaign) {
  Json json = Json::object();
  for (int i = 0; i < 6; ++i) {
    const auto value = [i](const Reading& r) {
      return i < 3 ? r.load.force[i] : r.load.moment[i - 3];
    };
    if (std::all_of(campaign.readings.begin(), campaign.readings.end(),
                    [&](const Reading& r) { return value(r) == 0; }))
      continue;
    static constexpr const char* names[] = {"fx", "fy", "fz", "mx", "my", "mz"};
    json[names[i]] = column(campaign, [&](const Reading& r) { return rounded(value(r)); });
  }
  return json;
}

const char* noise_word(calibration::NoiseSource source) {
  switch (source) {
    case calibration::NoiseSource::stated:
      return "stated";
    case calibration::NoiseSource::replicates:
      return "replicates";
    case calibration::NoiseSource::unknown:
      break;
  }
  return "unknown";
}

void add_circumstances(const Campaign& campaign, Json& json) {
  Names cycles;
  json["cycle"] = column(campaign, [&](const Reading& r) {
    return cycles.number(campaign.sessions[r.session] + "/" + r.cycle);
  });
  json["cycles"] = cycles.names();
  json["stated"] = column(campaign, [](const Reading& r) { return static_cast<int>(r.direction); });
  if (std::any_of(campaign.readings.begin(), campaign.readings.end(),
                  [](const Reading& r) { return r.time.has_value(); }))
    json["time"] =
        column(campaign, [](const Reading& r) { return r.time ? rounded(*r.time) : Json(); });
}

// Of the robot in the first posture, in which the others are seen.
void add_skeleton(const vjm::Robot& robot, const Campaign& campaign, Json& poses) {
  if (campaign.configurations.empty()) return;
  const vjm::Manipulator& manipulator = robot.without_effects();
  const vjm::PostureResult first = posture_of(manipulator, campaign.configurations.front());
  if (first.reached) poses.front()["skeleton"] = skeleton(manipulator, first.posture);
}

}  // namespace

Json configurations(const vjm::Robot& robot, const Campaign& campaign) {
  Json list = Json::array();
  const vjm::Manipulator& manipulator = robot.without_effects();
  for (const Configuration& configuration : campaign.configurations) {
    const vjm::PostureResult found = posture_of(manipulator, configuration);
    list.push_back({{"label", label(robot, configuration, found)},
                    {"position", io::to_json(found.posture.platform.position())}});
  }
  return list;
}

std::vector<ReadingsModel> readings_models(const calibration::Comparison& comparison) {
  std::vector<ReadingsModel> models{
      {"nominal", comparison.nominal.residual, comparison.nominal.whitened}};
  if (comparison.fitted)
    models.push_back({"fitted", comparison.fitted->residual, comparison.fitted->whitened});
  return models;
}

Json readings_picture(const vjm::Robot& robot, const Campaign& campaign,
                      const calibration::Noise& noise, const std::vector<ReadingsModel>& models) {
  const std::vector<Eigen::Index> components = measured(campaign);
  std::vector<Eigen::VectorXd> displacements;
  for (const Reading& reading : campaign.readings) displacements.push_back(reading.displacement);
  Json json{{"units",
             {{"length", campaign.units.length},
              {"force", campaign.units.force},
              {"angle", campaign.units.angle}}},
            {"noise", noise_word(noise.source)},
            {"poses", configurations(robot, campaign)},
            {"sessions", campaign.sessions},
            {"file", campaign.readings_file.filename().string()},
            {"line", column(campaign, [](const Reading& r) { return r.line; })},
            {"id", column(campaign, [](const Reading& r) { return Json(r.id); })},
            {"pose", column(campaign, [](const Reading& r) { return r.configuration; })},
            {"session", column(campaign, [](const Reading& r) { return r.session; })},
            {"role", column(campaign, [](const Reading& r) { return static_cast<int>(r.role); })},
            {"masked", column(campaign, [](const Reading& r) { return r.masked ? 1 : 0; })}};
  add_skeleton(robot, campaign, json["poses"]);
  add_circumstances(campaign, json);
  json["load"] = forces_json(campaign);
  json["measured"] = by_component(campaign, components, displacements);
  if (noise.source != calibration::NoiseSource::unknown)
    json["sigma"] = by_component(campaign, components, noise.sigma);
  json["models"] = Json::array();
  for (const ReadingsModel& model : models) {
    json["models"].push_back(
        {{"name", model.name}, {"residual", by_component(campaign, components, model.residual)}});
    if (noise.source != calibration::NoiseSource::unknown && !model.whitened.empty())
      json["models"].back()["whitened"] = by_component(campaign, components, model.whitened);
  }
  return json;
}

vjm::Robot with_found(const vjm::Robot& robot, const calibration::Diagnosis& diagnosis) {
  vjm::Robot better = robot;
  better.bare = robot.without_effects();
  for (const calibration::FoundEffect& found : diagnosis.found)
    better.effects.push_back(found.candidate.effect);
  return better;
}

}  // namespace kinetostat::report
