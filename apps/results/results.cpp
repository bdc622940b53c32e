#include "kinetostat/apps/results/results.h"

#include "kinetostat/apps/cli/campaign_request.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/report/comparison.h"
#include "kinetostat/report/diagnosis_file.h"
#include "kinetostat/report/kinematics.h"
#include "kinetostat/report/manipulators/manipulator.h"
#include "kinetostat/report/plan.h"
#include "kinetostat/report/readings_picture.h"
#include "kinetostat/report/screen/comparison.h"
#include "kinetostat/report/screen/diagnosis.h"
#include "kinetostat/report/screen/kinematics.h"
#include "kinetostat/report/screen/plan.h"

namespace kinetostat::apps {

io::Json diagnosis_result(const vjm::Robot& robot, const calibration::Campaign& campaign,
                          const calibration::DiagnosisOptions& options,
                          const calibration::Diagnosis& diagnosis) {
  io::Json json{{"headline", report::headline(robot, campaign, diagnosis)},
                {"inputs", report::provenance(robot)},
                {"readings", io::sha256(io::read_text(campaign.readings_file))},
                {"seed", options.seed},
                {"draws", options.draws}};
  json.update(report::to_json(robot, campaign, diagnosis));
  add_robot_replaced(robot, campaign, json);
  return json;
}

io::Json comparison_result(const vjm::Robot& robot, const calibration::Campaign& campaign,
                           const calibration::Comparison& comparison) {
  io::Json json{{"headline", report::headline(comparison)}, {"inputs", report::provenance(robot)}};
  add_robot_replaced(robot, campaign, json);
  json.update(report::to_json(campaign, comparison));
  json["configurations"] = report::configurations(robot, campaign);
  return json;
}

io::Json calibration_result(const vjm::Robot& robot, const calibration::Campaign& campaign,
                            const calibration::KinematicCalibration& calibration) {
  io::Json json{{"headline", report::headline(campaign, calibration)},
                {"inputs", report::provenance(robot)}};
  add_robot_replaced(robot, campaign, json);
  json.update(report::to_json(campaign, calibration));
  return json;
}

io::Json plan_result(const vjm::Robot& robot, const calibration::Campaign& campaign,
                     const calibration::PlanQuestion& question,
                     const calibration::PlanOptions& options, const calibration::Plan& plan) {
  io::Json json{{"headline", report::headline(robot, question, options, plan)},
                {"inputs", report::provenance(robot)},
                {"readings_so_far", io::sha256(io::read_text(campaign.readings_file))}};
  add_robot_replaced(robot, campaign, json);
  json.update(report::to_json(question, options, plan));
  json["work_list"] = report::to_json(report::work_list(robot, plan));
  return json;
}

}  // namespace kinetostat::apps
