// Readings: campaigns, comparison, diagnosis, adoption, plans.
#include <memory>
#include <optional>
#include <pybind11/eigen.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>
#include <variant>

#include <fmt/format.h>

#include "kinetostat/apps/cli/campaign_request.h"
#include "kinetostat/apps/cli/fit_cache.h"
#include "kinetostat/apps/results/adoption.h"
#include "kinetostat/apps/results/results.h"
#include "kinetostat/common/error.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/python/bindings.h"
#include "kinetostat/python/long_call.h"
#include "kinetostat/report/comparison.h"
#include "kinetostat/report/diagnosis.h"
#include "kinetostat/report/diagnosis_file.h"
#include "kinetostat/report/plan.h"
#include "kinetostat/report/readings_picture.h"
#include "kinetostat/report/screen/comparison.h"
#include "kinetostat/report/screen/diagnosis.h"
#include "kinetostat/report/screen/joint_curve.h"
#include "kinetostat/report/screen/plan.h"

namespace kinetostat::python {
namespace {

namespace py = pybind11;
using calibration::Campaign;
using Path = std::filesystem::path;
using RobotOrFile = std::variant<const RobotValue*, Path>;

RobotValue robot_of(const Path& campaign, const std::optional<RobotOrFile>& given) {
  if (!given) return robot_from(apps::CampaignRequest{{campaign.string()}}.read_robot().file);
  if (const auto* value = std::get_if<const RobotValue*>(&*given)) return **value;
  return robot_from(std::get<Path>(*given));
}

std::shared_ptr<CampaignValue> read_readings(const Path& file,
                                             const std::optional<RobotOrFile>& robot) {
  RobotValue measured = robot_of(file, robot);
  Campaign campaign = calibration::read_campaign(file, measured.robot.manipulator);
  return std::make_shared<CampaignValue>(CampaignValue{std::move(measured), std::move(campaign)});
}

Eigen::MatrixXd stacked(const std::vector<Eigen::VectorXd>& rows) {
  if (rows.empty()) return Eigen::MatrixXd(0, 0);
  Eigen::MatrixXd matrix(static_cast<Eigen::Index>(rows.size()), rows.front().size());
  for (std::size_t i = 0; i < rows.size(); ++i)
    matrix.row(static_cast<Eigen::Index>(i)) = rows[i].transpose();
  return matrix;
}

// The robot, and the file of the campaign, which is read again.
py::tuple pickled_campaign(const CampaignValue& value) {
  return py::make_tuple(value.campaign.file.string(), value.robot);
}

std::shared_ptr<CampaignValue> unpickled_campaign(const py::tuple& state) {
  RobotValue robot = state[1].cast<RobotValue>();
  Campaign campaign =
      calibration::read_campaign(state[0].cast<std::string>(), robot.robot.manipulator);
  return std::make_shared<CampaignValue>(CampaignValue{std::move(robot), std::move(campaign)});
}

// What every result has: a sentence, the report for people, and JSON as the commands write it.
struct Result {
  CampaignPointer campaign;
  std::string headline, text, json;
};

template <class Value>
py::class_<Value> result_class(py::module_& module, const char* name, const char* doc) {
  py::class_<Value> added(module, name, doc);
  added.def_property_readonly("headline", [](const Value& v) { return v.headline; })
      .def_property_readonly("text", [](const Value& v) { return v.text; })
      .def_property_readonly(
          "campaign",
          [](const Value& v) { return std::const_pointer_cast<CampaignValue>(v.campaign); })
      .def_property_readonly("result", [](const Value& v) { return values_of(v.json); })
      .def("to_json", [](const Value& v) { return v.json; })
      .def(
          "write", [](const Value& v, const Path& file) { io::write_atomically(file, v.json); },
          py::arg("file"))
      .def("__repr__", [name](const Value& v) { return fmt::format("{}: {}", name, v.headline); });
  return added;
}

// --- compare ----------------------------------------------------------------

struct ComparisonValue : Result {
  calibration::Comparison comparison;
};

std::string adequacy(const ComparisonValue& value) {
  switch (value.comparison.adequacy()) {
    case calibration::Adequacy::adequate:
      return "adequate";
    case calibration::Adequacy::inadequate:
      return "inadequate";
    case calibration::Adequacy::not_evaluated:
      return "not evaluated";
    case calibration::Adequacy::inconclusive:
      break;
  }
  return "inconclusive";
}

ComparisonValue compare(const CampaignPointer& given, const std::string& robust, int threads,
                        const py::object& progress) {
  if (!robust.empty() && robust != "huber" && robust != "cauchy")
    throw py::value_error("robust: '" + robust + "' is neither 'huber' nor 'cauchy'");
  ComparisonValue value{{given, {}, {}, {}}, {}};
  run_long(progress, [&](common::Progress& shown) {
    const vjm::Robot& robot = given->robot.robot;
    value.comparison = calibration::compare(robot, given->campaign, thread_count(threads), shown,
                                            {.loss = apps::loss_of(robust)});
    value.headline = report::headline(value.comparison);
    value.text = report::text(given->campaign, value.comparison);
    value.json = io::to_text(apps::comparison_result(robot, given->campaign, value.comparison));
  });
  return value;
}

// --- diagnose ---------------------------------------------------------------

struct DiagnosisValue : Result {
  std::shared_ptr<const calibration::Diagnosis> found = {};
};

struct Search {
  std::vector<std::string> effects;
  int draws;
  std::uint64_t seed;
  std::size_t most_effects;
  bool cache = true;
};

void require_known(const std::vector<std::string>& effects, const vjm::Robot& robot) {
  for (const std::string& kind : effects) (void)vjm::effect_kind(kind, robot.kinds());
}

// Fits are kept under the bytes of files: not those of a robot that is in no file, or in a part.
std::unique_ptr<apps::FitCache> cache_of(const CampaignValue& given, bool wanted) {
  io::Cache folder = wanted ? io::Cache::of_user() : io::Cache();
  const RobotValue& robot = given.robot;
  if (!folder.enabled() || !robot.kinds.empty() || !is_in_its_file(robot)) return nullptr;
  return std::make_unique<apps::FitCache>(std::move(folder), robot.robot, given.campaign,
                                          [](const std::string&) {});
}

DiagnosisValue diagnose(const CampaignPointer& given, const Search& search, int threads,
                        const py::object& progress) {
  if (search.draws < 99 || search.draws > 100'000)
    throw py::value_error(fmt::format("draws: {} is not from 99 to 100000", search.draws));
  if (search.most_effects < 1 || search.most_effects > 10)
    throw py::value_error(fmt::format("most_effects: {} is not from 1 to 10", search.most_effects));
  calibration::DiagnosisOptions options{.kinds = search.effects,
                                        .draws = search.draws,
                                        .seed = search.seed,
                                        .most_effects = search.most_effects};
  const vjm::Robot& robot = given->robot.robot;
  require_known(options.kinds, robot);
  const std::unique_ptr<apps::FitCache> cache = cache_of(*given, search.cache);
  options.journal = cache.get();
  DiagnosisValue value{{given, {}, {}, {}}, {}};
  run_long(progress, [&](common::Progress& shown) {
    calibration::Diagnosis found =
        calibration::diagnose(robot, given->campaign, options, thread_count(threads), shown);
    value.headline = report::headline(robot, given->campaign, found);
    value.text = report::text(robot, given->campaign, found);
    value.json = io::to_text(apps::diagnosis_result(robot, given->campaign, options, found));
    value.found = std::make_shared<const calibration::Diagnosis>(std::move(found));
  });
  return value;
}

// Load and deflection at the joint of the first effect that was found; None where there is none.
py::object joint_curve(const DiagnosisValue& value, int threads, const py::object& progress) {
  io::Json curve;
  run_long(progress, [&](common::Progress& shown) {
    const vjm::Robot& robot = value.campaign->robot.robot;
    const Campaign& campaign = value.campaign->campaign;
    if (value.found->found.empty()) return;
    const int count = thread_count(threads);
    const auto before = calibration::compare(robot, campaign, count, shown);
    const auto after =
        calibration::compare(report::with_found(robot, *value.found), campaign, count, shown);
    curve = report::joint_curve_picture(robot, campaign, *value.found, before, after, count, shown);
  });
  return curve.is_null() ? py::object(py::none()) : values_of(io::to_text(curve));
}

calibration::DiagnosisRecord record_of(const DiagnosisValue& value) {
  return report::diagnosis_record(io::Json::parse(value.json), "the diagnosis");
}

// --- adopt ------------------------------------------------------------------

struct AdoptionValue {
  apps::Adopted adopted;
  RobotValue robot;  // that the adoption is for
};

AdoptionValue adopt(const DiagnosisValue& value, const std::string& effect, bool effects_only,
                    bool stiffnesses_only, bool force) {
  const RobotValue& robot = value.campaign->robot;
  const Path& file = robot.robot.file;
  if (!is_in_its_file(robot))
    throw py::value_error(fmt::format(
        "{} has not the robot that was diagnosed: write() that, and diagnose what is read from it",
        file.string()));
  return {apps::adopt(record_of(value),
                      {.robot = file.string(),
                       .diagnosis = "the diagnosis",
                       .effect = effect,
                       .force = force,
                       .effects_only = effects_only,
                       .stiffnesses_only = stiffnesses_only,
                       .reading = {.kinds = robot.kinds}},
                      file),
          robot};
}

// --- plan -------------------------------------------------------------------

struct PlanValue : Result {
  std::string table;  // of readings, CSV
};

PlanValue plan(const CampaignPointer& given, const DiagnosisValue* diagnosis,
               const std::vector<std::string>& show, double minutes, int threads,
               const py::object& progress) {
  if (!(minutes > 0)) throw py::value_error("minutes must be above 0");
  const DiagnosisValue made =
      diagnosis != nullptr ? *diagnosis : diagnose(given, {{}, 500, 1, 3}, threads, progress);
  PlanValue value{{given, {}, {}, {}}, {}};
  run_long(progress, [&](common::Progress& shown) {
    const vjm::Robot& robot = given->robot.robot;
    calibration::PlanOptions options;
    options.minutes = minutes;
    const calibration::PlanQuestion question =
        calibration::question_of(robot, record_of(made), show);
    const calibration::Plan found =
        calibration::plan(robot, given->campaign, question, options, thread_count(threads), shown);
    value.headline = report::headline(robot, question, options, found);
    value.text = report::text(robot, given->campaign, question, options, found);
    value.json = io::to_text(apps::plan_result(robot, given->campaign, question, options, found));
    if (!found.blocks.empty()) value.table = report::plan_table(robot, found);
  });
  return value;
}

// ----------------------------------------------------------------------------

void add_campaigns(py::module_& module) {
  py::class_<CampaignValue, std::shared_ptr<CampaignValue>>(
      module, "Campaign", "Readings, and the robot that they are of.")
      .def_static("read", &read_readings, py::arg("file"), py::arg("robot") = py::none())
      .def_property_readonly("name", [](const CampaignValue& v) { return v.campaign.name; })
      .def_property_readonly("robot", [](const CampaignValue& v) { return v.robot; })
      .def_property_readonly("notes", [](const CampaignValue& v) { return v.campaign.notes; })
      .def_property_readonly("warnings", [](const CampaignValue& v) { return v.campaign.warnings; })
      .def_property_readonly(
          "has_loads_besides_wrench",
          [](const CampaignValue& v) {
            return std::any_of(
                v.campaign.readings.begin(), v.campaign.readings.end(),
                [](const auto& r) { return !r.load.nodes.empty() || !r.load.joints.empty(); });
          })
      .def_property_readonly("components",
                             [](const CampaignValue& v) {
                               std::vector<std::string> names;
                               for (const calibration::Component& c : v.campaign.components)
                                 names.push_back(c.name);
                               return names;
                             })
      .def("columns", &columns_of)
      .def(py::pickle(&pickled_campaign, &unpickled_campaign))
      .def("__len__", [](const CampaignValue& v) { return v.campaign.readings.size(); })
      .def("__repr__", [](const CampaignValue& v) {
        return fmt::format("Campaign '{}': {} readings of {}", v.campaign.name,
                           v.campaign.readings.size(), v.robot.robot.name);
      });
}

void add_comparison(py::module_& module) {
  result_class<ComparisonValue>(module, "Comparison", "A model against readings.")
      .def_property_readonly("adequacy", &adequacy)
      .def_property_readonly(
          "error_over_noise",
          [](const ComparisonValue& v) { return v.comparison.best().error_over_noise(); })
      .def_property_readonly(
          "residuals",
          [](const ComparisonValue& v) { return stacked(v.comparison.best().residual); })
      .def_property_readonly("whitened", [](const ComparisonValue& v) {
        return stacked(v.comparison.best().whitened);
      });
  module.def("compare", &compare, py::arg("campaign").none(false), py::arg("robust") = "",
             py::kw_only(), py::arg("threads") = 0, py::arg("progress") = py::none());
}

void add_diagnosis(py::module_& module) {
  result_class<DiagnosisValue>(module, "Diagnosis", "Which physical effect a model lacks.")
      .def_property_readonly(
          "verdict",
          [](const DiagnosisValue& v) { return py::object(values_of(v.json)["verdict"]); })
      .def_property_readonly(
          "found", [](const DiagnosisValue& v) { return py::object(values_of(v.json)["found"]); })
      .def("joint_curve", &joint_curve, py::kw_only(), py::arg("threads") = 0,
           py::arg("progress") = py::none());
  module.def(
      "diagnose",
      [](const CampaignPointer& campaign, const std::vector<std::string>& effects, int draws,
         std::uint64_t seed, std::size_t most_effects, bool cache, int threads,
         const py::object& progress) {
        return diagnose(campaign, {effects, draws, seed, most_effects, cache}, threads, progress);
      },
      py::arg("campaign").none(false), py::arg("effects") = std::vector<std::string>(),
      py::kw_only(), py::arg("draws") = 500, py::arg("seed") = 1, py::arg("most_effects") = 3,
      py::arg("cache") = true, py::arg("threads") = 0, py::arg("progress") = py::none());
}

void add_adoption(py::module_& module) {
  py::class_<AdoptionValue>(module, "Adoption", "A robot file with what a diagnosis found.")
      .def_property_readonly(
          "headline",
          [](const AdoptionValue& v) { return v.adopted.result["headline"].get<std::string>(); })
      .def_property_readonly("text", [](const AdoptionValue& v) { return v.adopted.text; })
      .def_property_readonly(
          "result", [](const AdoptionValue& v) { return values_of(io::to_text(v.adopted.result)); })
      .def_property_readonly(
          "robot",
          [](const AdoptionValue& v) {
            const vjm::EffectKinds& kinds = v.robot.kinds;
            return RobotValue{
                vjm::parse_robot(v.adopted.text, v.robot.robot.file, {.kinds = kinds}),
                v.adopted.text, kinds};
          })
      .def(
          "write",
          [](const AdoptionValue& v, const Path& file) {
            return write_robot(file, v.adopted.text, v.robot.kinds);
          },
          py::arg("file"))
      .def("__repr__", [](const AdoptionValue& v) {
        return "Adoption: " + v.adopted.result["headline"].get<std::string>();
      });
  module.def("adopt", &adopt, py::arg("diagnosis"), py::arg("effect") = "", py::kw_only(),
             py::arg("effects_only") = false, py::arg("stiffnesses_only") = false,
             py::arg("force") = false);
}

void add_plan(py::module_& module) {
  result_class<PlanValue>(module, "Plan", "What to measure next.")
      .def_readonly("table", &PlanValue::table);
  module.def("plan", &plan, py::arg("campaign").none(false), py::arg("diagnosis") = py::none(),
             py::kw_only(), py::arg("show") = std::vector<std::string>(),
             py::arg("minutes") = 120.0, py::arg("threads") = 0, py::arg("progress") = py::none());
}

}  // namespace

void add_readings(py::module_& module) {
  add_campaigns(module);
  add_comparison(module);
  add_diagnosis(module);
  add_adoption(module);
  add_plan(module);
}

}  // namespace kinetostat::python
