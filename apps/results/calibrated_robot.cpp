#include "kinetostat/apps/results/calibrated_robot.h"

#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include <fmt/format.h>

#include "kinetostat/apps/cli/version.h"
#include "kinetostat/calibration/diagnosis/adoption.h"
#include "kinetostat/common/error.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/report/screen/kinematics.h"

namespace kinetostat::apps {
namespace {

using calibration::AdoptedEffect;
using calibration::AdoptedParameter;
using calibration::Adoption;
using calibration::CalibratedGeometry;
using calibration::KinematicCalibration;

const std::string& component_name(const KinematicCalibration& c, const CalibratedGeometry& g) {
  return c.effects[g.what.effect].kind->parameters[static_cast<std::size_t>(g.what.component)].name;
}

std::vector<std::string> reasons_for(const calibration::Campaign& campaign,
                                     const KinematicCalibration& c) {
  return {fmt::format("kinematic calibration by kinetostat {}: {}", version(),
                      report::headline(campaign, c)),
          fmt::format("readings: {}, sha256 {}", campaign.readings_file.filename().string(),
                      io::sha256(io::read_text(campaign.readings_file)))};
}

// In the units of the robot file.
calibration::AdoptedValue value_of(const vjm::Robot& robot, const std::string& name,
                                   const CalibratedGeometry& g) {
  return calibration::in_units_of(robot.units, {name, g.what.unit(), g.value, g.deviation});
}

// A new effect for each place, from base to end; those that the file has get other values.
void add_geometry(const vjm::Robot& robot, const calibration::Campaign& campaign,
                  const KinematicCalibration& c, Adoption& adoption) {
  for (std::size_t e = 0; e < c.effects.size(); ++e) {
    AdoptedEffect adopted{
        .effect = c.effects[e].kind->name, .at = c.effects[e].at, .values = {}, .reasons = {}};
    for (const CalibratedGeometry& g : c.geometry) {
      if (g.what.effect != e) continue;
      const std::string& name = component_name(c, g);
      if (e >= c.own_effects)
        adopted.values.push_back(value_of(robot, name, g));
      else
        adoption.fitted.push_back({.stiffness = {},
                                   .effect = adopted.effect,
                                   .at = adopted.at,
                                   .parameter = name,
                                   .value = value_of(robot, "value", g),
                                   .remark = {}});
    }
    if (adopted.values.empty()) continue;
    if (adoption.effects.empty()) adopted.reasons = reasons_for(campaign, c);
    adoption.effects.push_back(std::move(adopted));
  }
}

// What was fitted beside the geometry; at a bound nothing is known of its deviation.
AdoptedParameter parameter_of(const vjm::Robot& robot, const calibration::ParameterEstimate& e) {
  const double deviation = e.hit == calibration::BoundHit::none
                               ? e.standard_error
                               : std::numeric_limits<double>::quiet_NaN();
  AdoptedParameter adopted;
  if (e.parameter.is_logarithm()) {
    adopted.stiffness = e.parameter.name;
    adopted.value = {"factor", "", std::exp(e.value), std::exp(e.value) * deviation};
    return adopted;
  }
  const vjm::Effect& effect = robot.effects[e.parameter.effect];
  adopted.effect = effect.kind->name;
  adopted.at = effect.at;
  adopted.parameter = effect.kind->parameters[static_cast<std::size_t>(e.parameter.value)].name;
  adopted.value =
      calibration::in_units_of(robot.units, {"value", e.parameter.unit, e.value, deviation});
  return adopted;
}

// The name of an estimate as a source of uncertainty; empty for one without a standard deviation,
// and for what only readings see.
std::string source_of(const vjm::Robot& robot, const calibration::ParameterEstimate& e) {
  if (e.hit != calibration::BoundHit::none || !(e.standard_error > 0)) return {};
  if (!e.parameter.is_logarithm())
    return robot.effects[e.parameter.effect].kind->acts_on_chains() ? e.parameter.name : "";
  return vjm::fitted_source(e.parameter.name);
}

calibration::EstimateCorrelation correlation_of(const vjm::Robot& robot,
                                                const KinematicCalibration& c) {
  calibration::EstimateCorrelation all{.names = {}, .matrix = c.correlation};
  for (const CalibratedGeometry& g : c.geometry)
    all.names.push_back(g.deviation > 0 ? c.effects[g.what.effect].name_of(g.what.component) : "");
  for (const calibration::ParameterEstimate& e : c.others) all.names.push_back(source_of(robot, e));
  std::vector<std::string> known = all.names;
  std::erase(known, "");
  return all.only(known);
}

Adoption adoption_of(const vjm::Robot& robot, const calibration::Campaign& campaign,
                     const KinematicCalibration& c) {
  Adoption adoption;
  add_geometry(robot, campaign, c, adoption);
  for (const calibration::ParameterEstimate& e : c.others)
    adoption.fitted.push_back(parameter_of(robot, e));
  add_correlation(robot, correlation_of(robot, c), adoption);
  return adoption;
}

}  // namespace

std::string calibrated_robot(const vjm::Robot& robot, const std::string& text,
                             const calibration::Campaign& campaign,
                             const KinematicCalibration& calibration) {
  try {
    return calibration::adopted(text, adoption_of(robot, campaign, calibration));
  } catch (const std::invalid_argument& error) {
    throw common::InputError({.file = robot.file, .what = error.what()});
  }
}

}  // namespace kinetostat::apps
