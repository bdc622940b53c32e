#include "kinetostat/report/plan.h"

#include <cmath>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "kinetostat/calibration/campaign/joint_column.h"
#include "kinetostat/common/error.h"
#include "kinetostat/io/csv.h"
#include "kinetostat/report/diagnosis.h"
#include "kinetostat/report/manipulators/joint_motion.h"
#include "kinetostat/report/text/text.h"

namespace kinetostat::report {
namespace {

using calibration::Campaign;
using calibration::DisplacementKind;
using calibration::Plan;
using calibration::PlanBlock;
using calibration::PlannedSharpening;
using calibration::PlannedSplit;
using calibration::Reading;
using io::Json;

// Figures of the units of a robot file.
struct Units {
  const spatial::UnitSystem& names;

  double length(double si) const { return si / spatial::parse_unit(names.length).factor; }
  double angle(double si) const { return si / spatial::parse_unit(names.angle).factor; }
  double force(double si) const { return si / spatial::parse_unit(names.force).factor; }
  double moment(double si) const {
    return si / spatial::parse_unit(names.unit_for(spatial::dimension::moment)).factor;
  }
  double time(double si) const { return si / spatial::parse_unit(names.time).factor; }
};

// Rounding of a change of units is taken off.
std::string figure(double value) {
  const std::string text = fmt::format("{:.9g}", value);
  return text == "-0" ? "0" : text;
}

std::string posture_text(const vjm::Robot& robot, const calibration::Configuration& c) {
  const Units units{robot.units};
  if (c.target) {
    const spatial::Vector3 p = c.target->position();
    return fmt::format("({}, {}, {}) {}", number(units.length(p.x()), 5),
                       number(units.length(p.y()), 5), number(units.length(p.z()), 5),
                       robot.units.length);
  }
  std::string text;
  for (const auto& [joint, value] : c.joints) {
    const bool turns = joint_turns(robot, joint);
    text += fmt::format("{}{} = {} {}", text.empty() ? "" : ", ", joint,
                        number(turns ? units.angle(value) : units.length(value), 5),
                        turns ? robot.units.angle : robot.units.length);
  }
  return text.empty() ? "home" : text;
}

std::string load_text(const vjm::Robot& robot, const PlanBlock& block) {
  if (block.direction.empty()) return "no load";
  const Units units{robot.units};
  const bool moment = block.direction[1] == 'm';
  return fmt::format("{} to {} {}", block.direction,
                     number(moment ? units.moment(block.level()) : units.force(block.level()), 4),
                     moment ? robot.units.force + " " + robot.units.length : robot.units.force);
}

spatial::Vector3 roll_pitch_yaw(const spatial::Matrix3& r) {
  const Eigen::Vector3d zyx = r.eulerAngles(2, 1, 0);
  return {zyx[2], zyx[1], zyx[0]};
}

// Columns and cells of the postures.
class PostureColumns {
 public:
  PostureColumns(const vjm::Robot& robot, const Campaign& plan) : robot_(robot), plan_(plan) {
    for (const auto& c : plan.configurations) {
      turned_ = turned_ || (c.target && !c.target->rotation().isIdentity(1e-12));
      posed_ = posed_ || c.target.has_value();
      for (const auto& [name, value] : c.joints) joints_[name] = joint_turns(robot, name);
    }
  }
  std::string header() const {
    std::string text;
    if (posed_) text += ",x,y,z";
    if (turned_) text += ",roll,pitch,yaw";
    for (const auto& [name, turns] : joints_) {
      const auto given = plan_.joint_columns.find(name);
      text += "," + io::csv_cell(given != plan_.joint_columns.end()
                                     ? given->second.column
                                     : calibration::joint_column(robot_.manipulator, name));
    }
    return text;
  }
  std::string cells(const Reading& reading) const {
    const Units units{robot_.units};
    const auto& c = plan_.configurations[reading.configuration];
    std::string text;
    if (c.target) {
      for (const double v : c.target->position()) text += "," + figure(units.length(v));
      if (turned_)
        for (const double v : roll_pitch_yaw(c.target->rotation()))
          text += "," + figure(units.angle(v));
    }
    for (const auto& [name, turns] : joints_) {
      const auto found = c.joints.find(name);
      const double value = found == c.joints.end() ? 0 : found->second;
      text += "," + figure(turns ? units.angle(value) : units.length(value));
    }
    return text;
  }

 private:
  const vjm::Robot& robot_;
  const Campaign& plan_;
  bool posed_ = false, turned_ = false;
  std::map<std::string, bool> joints_;  // whether they turn
};

bool has_moments(const Plan& plan) {
  for (const Reading& reading : plan.readings.readings)
    if (!reading.load.moment.isZero(0)) return true;
  return false;
}

std::string splits_text(const Plan& plan) {
  Table table({"", "from", "d' expected", "nats", "d' at most"});
  for (const PlannedSplit& s : plan.splits)
    table.add_row({s.a, s.b, number(s.separation, 3), number(s.nats, 3), number(s.most, 3)});
  std::string text =
      "\nPairs that the batch is expected to distinguish, the hardest first\n" + table.text();
  for (const PlannedSplit& s : plan.splits)
    if (!s.advice.empty())
      text += fmt::format("Readings of this kind do not distinguish {} from {}: {}.\n", s.a, s.b,
                          s.advice);
  return text;
}

std::string sharpened_text(const vjm::Robot& robot, const Plan& plan) {
  Table table({"", "sd now", "sd expected", "unit"});
  for (const PlannedSharpening& s : plan.sharpened)
    table.add_row({s.name, number(s.before, 3), number(s.after, 3),
                   s.unit.empty() ? "of the logarithm" : s.unit});
  const Units units{robot.units};
  return "\nHow much sharper the model is expected to be\n" + table.text() +
         fmt::format(
             "Displacements where it is used, under the largest loads: {} {} unsure now, {} {} "
             "expected.\n",
             number(units.length(plan.work_before), 3), robot.units.length,
             number(units.length(plan.work_after), 3), robot.units.length);
}

std::string blocks_text(const vjm::Robot& robot, const Plan& plan) {
  Table table({"cycle", "posture", "load", "how", "readings", "min", "for"});
  for (std::size_t b = 0; b < plan.blocks.size(); ++b) {
    const PlanBlock& block = plan.blocks[b];
    table.add_row({fmt::format("p{}", b + 1),
                   posture_text(robot, plan.readings.configurations[block.configuration]),
                   load_text(robot, block), block.pattern->name,
                   std::to_string(block.pattern->steps.size()), number(block.minutes, 3),
                   plan.why[b]});
  }
  return table.text();
}

std::string kind_text(const Plan& plan) {
  if (plan.asks_for_absolute)
    return "Read absolute poses, a campaign of their own: in differences from the unloaded state "
           "the wanted effect cancels. The uncertain parameters are fitted there; the plan allows "
           "for that.\n";
  if (plan.asks_for_weights)
    return "Load it by known weights, in a session of their own that 'known_loads' of the campaign "
           "file lists: readings of the load cell do not show its errors.\n";
  return plan.displacement == DisplacementKind::absolute ? "Read absolute poses, as so far.\n"
                                                         : "Read differences, as so far.\n";
}

std::string purpose_text(const calibration::PlanQuestion& question) {
  if (question.open.empty())
    return fmt::format("Verdict so far: {}. No candidate is left: readings to sharpen the model.\n",
                       verdict_in_words(question.verdict));
  std::string names;
  for (const calibration::OpenCandidate& open : question.open)
    names += (names.empty() ? "" : "; ") + open.candidate.name();
  return fmt::format("Verdict so far: {}. Readings to distinguish: {}{}.\n",
                     verdict_in_words(question.verdict), names,
                     question.perhaps_nothing ? "; nothing more" : "");
}

}  // namespace

std::string text(const vjm::Robot& robot, const Campaign& campaign,
                 const calibration::PlanQuestion& question, const calibration::PlanOptions& options,
                 const Plan& plan) {
  std::string text = fmt::format("\nPlan for '{}'\n", campaign.name) + purpose_text(question);
  if (!plan.blocks.empty()) {
    text += kind_text(plan) + "\n" + blocks_text(robot, plan);
    text +=
        fmt::format("{} readings in {} cycles, about {} min of {}\n", plan.readings.readings.size(),
                    plan.blocks.size(), number(plan.minutes, 3), number(options.minutes, 3));
  }
  if (!plan.splits.empty()) text += splits_text(plan);
  if (!plan.sharpened.empty()) text += sharpened_text(robot, plan);
  for (const std::string& note : plan.notes) text += note + "\n";
  return text;
}

std::string plan_table(const vjm::Robot& robot, const Plan& plan) {
  const Units units{robot.units};
  const PostureColumns postures(robot, plan.readings);
  const bool moments = has_moments(plan),
             repeats = !plan.readings.readings.front().replicate.empty();
  const spatial::Vector3& point = plan.readings.readings.front().load.point_on_platform;
  const std::string kind = kind_text(plan);
  std::string text = io::csv_comment(fmt::format(
      "Readings to take, in the units of {}: {}, {}, {}, {}; about {} min. {}",
      robot.file.filename().string(), robot.units.length, robot.units.force, robot.units.angle,
      robot.units.time, number(plan.minutes, 3), kind.substr(0, kind.find('\n'))));
  text += io::csv_comment(
      fmt::format("'kinetostat simulate ROBOT --plan' takes this file as it is{}.",
                  plan.displacement == DisplacementKind::absolute ? ", with --absolute" : ""));
  text += "id,session,cycle,step,time" + std::string(repeats ? ",replicate" : "") +
          postures.header() + ",fx,fy,fz" + (moments ? ",mx,my,mz" : "") +
          (point.isZero(0) ? "" : ",px,py,pz") + "\n";
  std::size_t block = 0;
  std::string cycle;
  for (const Reading& r : plan.readings.readings) {
    if (r.cycle != cycle) {
      const PlanBlock& now = plan.blocks[block];
      text += io::csv_comment(
          fmt::format("{}: {} at {}, {}; {}", r.cycle, load_text(robot, now),
                      posture_text(robot, plan.readings.configurations[now.configuration]),
                      now.pattern->name, plan.why[block]));
      cycle = r.cycle;
      ++block;
    }
    text += fmt::format("{},{},{},{},{}", io::csv_cell(r.id),
                        io::csv_cell(plan.readings.sessions[r.session]), io::csv_cell(r.cycle),
                        figure(*r.step), figure(units.time(*r.time)));
    if (repeats) text += "," + io::csv_cell(r.replicate);
    text += postures.cells(r);
    for (const double f : r.load.force) text += "," + figure(units.force(f));
    if (moments)
      for (const double m : r.load.moment) text += "," + figure(units.moment(m));
    if (!point.isZero(0))
      for (const double x : point) text += "," + figure(units.length(x));
    text += "\n";
  }
  return text;
}

Json to_json(const calibration::PlanQuestion& question, const calibration::PlanOptions& options,
             const Plan& plan) {
  Json open = Json::array(), blocks = Json::array(), splits = Json::array(),
       sharpened = Json::array();
  for (const calibration::OpenCandidate& s : question.open)
    open.push_back({{"name", s.candidate.name()}, {"fitted", s.is_fitted}});
  for (std::size_t b = 0; b < plan.blocks.size(); ++b) {
    const PlanBlock& block = plan.blocks[b];
    blocks.push_back({{"cycle", fmt::format("p{}", b + 1)},
                      {"configuration", block.configuration},
                      {"direction", block.direction},
                      {"level", block.level()},
                      {"pattern", block.pattern->name},
                      {"readings", block.pattern->steps.size()},
                      {"minutes", block.minutes},
                      {"why", plan.why[b]}});
  }
  for (const PlannedSplit& s : plan.splits) {
    splits.push_back({{"a", s.a},
                      {"b", s.b},
                      {"separation", s.separation},
                      {"nats", s.nats},
                      {"most", s.most},
                      {"log_evidence_difference_so_far", nullptr}});
    if (s.so_far) splits.back()["log_evidence_difference_so_far"] = *s.so_far;
    if (!s.advice.empty()) splits.back()["advice"] = s.advice;
  }
  for (const PlannedSharpening& s : plan.sharpened)
    sharpened.push_back({{"name", s.name},
                         {"unit", s.unit},
                         {"deviation_now", s.before},
                         {"deviation_expected", s.after}});
  const auto optional = [](double x) { return std::isnan(x) ? Json() : Json(x); };
  return {
      {"verdict", question.verdict},
      {"suspects", open},
      {"perhaps_nothing", question.perhaps_nothing},
      {"displacement", plan.displacement == DisplacementKind::absolute ? "absolute" : "difference"},
      {"asks_for_absolute", plan.asks_for_absolute},
      {"asks_for_weights", plan.asks_for_weights},
      {"minutes", plan.minutes},
      {"minutes_allowed", options.minutes},
      {"readings", plan.readings.readings.size()},
      {"cycles", blocks},
      {"splits", splits},
      {"sharpened", sharpened},
      {"work", {{"now", optional(plan.work_before)}, {"expected", optional(plan.work_after)}}},
      {"notes", plan.notes}};
}

calibration::PlanPromise promise_of(const Json& plan, const std::filesystem::path& file) {
  calibration::PlanPromise promise;
  try {
    for (const Json& s : plan.at("splits")) {
      PlannedSplit split;
      split.a = s.at("a").get<std::string>();
      split.b = s.at("b").get<std::string>();
      split.nats = s.at("nats").get<double>();
      if (const Json& so_far = s.at("log_evidence_difference_so_far"); !so_far.is_null())
        split.so_far = so_far.get<double>();
      promise.splits.push_back(std::move(split));
    }
    for (const Json& s : plan.at("sharpened"))
      promise.sharpened.push_back({.name = s.at("name").get<std::string>(),
                                   .unit = s.value("unit", ""),
                                   .before = s.at("deviation_now").get<double>(),
                                   .after = s.at("deviation_expected").get<double>()});
  } catch (const Json::exception& error) {
    throw common::InputError({.file = file,
                              .what = fmt::format("this is no plan: {}", error.what()),
                              .cure = "Give the file that 'kinetostat plan --json' wrote"});
  }
  return promise;
}

std::string text(const calibration::PlanScore& score) {
  std::string text = "\nWhat the plan promised, and what its readings gave\n";
  if (!score.splits.empty()) {
    Table table({"", "from", "nats expected", "nats realised"});
    for (const calibration::SplitScore& s : score.splits)
      table.add_row({s.a, s.b, number(s.expected, 3),
                     s.realised ? number(*s.realised, 3) : "- (" + s.why_not + ")"});
    text += table.text();
  }
  if (!score.sharpened.empty()) {
    Table table({"", "sd before", "sd expected", "sd realised"});
    for (const calibration::SharpeningScore& s : score.sharpened)
      table.add_row({s.name, number(s.before, 3), number(s.expected, 3),
                     s.realised ? number(*s.realised, 3) : "-"});
    text += table.text();
  }
  return text;
}

Json to_json(const calibration::PlanScore& score) {
  Json splits = Json::array(), sharpened = Json::array();
  for (const calibration::SplitScore& s : score.splits) {
    splits.push_back(
        {{"a", s.a}, {"b", s.b}, {"nats_expected", s.expected}, {"nats_realised", nullptr}});
    if (s.realised)
      splits.back()["nats_realised"] = *s.realised;
    else
      splits.back()["reason"] = s.why_not;
  }
  for (const calibration::SharpeningScore& s : score.sharpened) {
    sharpened.push_back({{"name", s.name},
                         {"deviation_before", s.before},
                         {"deviation_expected", s.expected},
                         {"deviation_realised", nullptr}});
    if (s.realised) sharpened.back()["deviation_realised"] = *s.realised;
  }
  return {{"splits", splits}, {"sharpened", sharpened}};
}

}  // namespace kinetostat::report
