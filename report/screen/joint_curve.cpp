#include "kinetostat/report/screen/joint_curve.h"

#include <fmt/format.h>

#include "kinetostat/report/manipulators/joint_motion.h"
#include "kinetostat/report/manipulators/skeleton.h"
#include "kinetostat/report/readings_picture.h"
#include "kinetostat/report/screen/wording.h"
#include "kinetostat/vjm/manipulator/posture.h"

namespace kinetostat::report {
namespace {

using calibration::JointCurvePoint;
using io::Json;

Json column(const std::vector<JointCurvePoint>& points, double JointCurvePoint::*member) {
  Json list = Json::array();
  for (const JointCurvePoint& p : points) list.push_back(p.*member);
  return list;
}

std::pair<Json, Json> ids_and_cycles(const calibration::Campaign& campaign,
                                     const std::vector<JointCurvePoint>& points) {
  Json ids = Json::array(), cycles = Json::array();
  for (const JointCurvePoint& p : points) {
    const calibration::Reading& reading = campaign.readings[p.reading];
    ids.push_back(reading.id);
    cycles.push_back(
        fmt::format("{}/{}/{}", reading.session, reading.cycle, reading.configuration));
  }
  return {ids, cycles};
}

Json picture_of(const vjm::Robot& robot, const calibration::Campaign& campaign,
                const vjm::Effect& effect, const std::vector<JointCurvePoint>& points) {
  const auto [ids, cycles] = ids_and_cycles(campaign, points);
  const std::string& chain = robot.without_effects().chains()[effect.sites.front().chain].name();
  return {{"place", place_in_words(robot.without_effects(), effect.at)},
          {"effect", effect_in_words(robot.without_effects(), effect.kind->name, effect.at)},
          {"joint", chain + "." + effect.sites.front().element},
          {"turns", joint_turns(robot, chain + "." + effect.sites.front().element)},
          {"id", ids},
          {"cycle", cycles},
          {"load", column(points, &JointCurvePoint::load)},
          {"measured", column(points, &JointCurvePoint::measured)},
          {"without", column(points, &JointCurvePoint::without)},
          {"with", column(points, &JointCurvePoint::with)},
          {"spring", column(points, &JointCurvePoint::spring)},
          {"deviation", column(points, &JointCurvePoint::deviation)}};
}

}  // namespace

Json bent_robot_picture(const vjm::Robot& robot, const calibration::Campaign& campaign,
                        const calibration::Diagnosis& diagnosis) {
  const calibration::Reading* largest = nullptr;
  for (const calibration::Reading& reading : campaign.readings)
    if (!reading.masked &&
        (largest == nullptr || reading.load.force.norm() > largest->load.force.norm()))
      largest = &reading;
  if (largest == nullptr) return {};
  const calibration::Configuration& c = campaign.configurations[largest->configuration];
  const vjm::Manipulator& bare = robot.without_effects();
  const vjm::PostureResult posture =
      c.target ? posture_at(bare, *c.target) : posture_from_joints(bare, c.joints);
  if (!posture.reached) return {};
  const vjm::Equilibrium bent = equilibrium_under_load(bare, posture.posture, largest->load);
  if (bent.status != vjm::EquilibriumStatus::converged) return {};
  Json json{{"skeletons",
             {named_skeleton("unloaded", skeleton(bare.without_errors(), posture.posture)),
              named_skeleton("loaded", skeleton(bare, bent))}},
            {"load",
             {{"at", io::to_json(bent.platform * largest->load.point_on_platform)},
              {"force", io::to_json(largest->load.force)}}},
            {"joint", nullptr}};
  if (!diagnosis.found.empty() && !diagnosis.by_kinematics)
    json["joint"] = diagnosis.found.front().candidate.effect.at;
  return json;
}

Json joint_curve_picture(const vjm::Robot& robot, const calibration::Campaign& campaign,
                         const calibration::Diagnosis& diagnosis,
                         const calibration::Comparison& before,
                         const calibration::Comparison& after, int threads,
                         common::Progress& progress) {
  const vjm::Robot adopted = with_found(robot, diagnosis);
  for (const calibration::FoundEffect& found : diagnosis.found) {
    const vjm::Effect& effect = found.candidate.effect;
    if (effect.sites.empty() || effect.sites.front().element.empty()) continue;
    const auto points =
        calibration::joint_curve(robot, adopted, campaign, before.noise, before.best(),
                                 after.best(), effect.sites.front(), threads, progress);
    if (points) return picture_of(robot, campaign, effect, *points);
  }
  return {};
}

}  // namespace kinetostat::report
