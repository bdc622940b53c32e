// kinetostat demo: end to end on the shipped Orthoglide, from the meshes of its links to the effect
// that its model lacks.
#include <chrono>
#include <memory>

#include <fmt/format.h>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/cli/shipped_files.h"
#include "kinetostat/apps/commands/commands.h"
#include "kinetostat/apps/commands/diagnosis_steps.h"
#include "kinetostat/calibration/campaign/campaign_file.h"
#include "kinetostat/calibration/comparison/compare.h"
#include "kinetostat/common/error.h"
#include "kinetostat/fea/link/displacement_fields.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/report/comparison.h"
#include "kinetostat/report/diagnosis.h"
#include "kinetostat/report/diagnosis_file.h"
#include "kinetostat/report/links/link_picture.h"
#include "kinetostat/report/links/link_result.h"
#include "kinetostat/report/text/text.h"
#include "kinetostat/report/waterfall.h"
#include "kinetostat/vjm/io/robot_file.h"
#include "kinetostat/vjm/manipulator/posture.h"
#include "kinetostat/vjm/statics/equilibrium.h"
#include "kinetostat/vjm/statics/stiffness.h"

namespace kinetostat::apps {
namespace {

using std::filesystem::path;

struct Request {
  std::string folder = "kinetostat-demo";
};

const spatial::UnitSystem mm_newton{.length = "mm", .force = "N"};

// 1. A link from its mesh. Returns what the JSON keeps of it.
io::Json identify_link(const std::string& name, const path& folder, Run& run) {
  const fea::LinkSpec spec = fea::read_link(shipped("meshes/" + name + ".yaml"));
  const fea::LinkResult result =
      fea::identify(spec, fea::read_geometry(spec, run.progress()), {}, run.progress());
  const path link_file = folder / "links" / (name + ".link.json");
  io::write_json(link_file, report::to_json(result));
  io::write_vtu(folder / "links" / (name + ".vtu"), fea::displacement_fields(result));
  if (run.wants_page()) {
    io::Json shown = report::to_json(result);
    shown["command"] = "identify";
    run.add_to_page({.result = std::move(shown),
                     .picture = {{"surface", report::link_picture(result)}},
                     .text = {}});
  }
  run.print(
      fmt::format("Link '{}': {} tetrahedra, {} unknowns, {} kg, symmetry defect {:.0e}\n{}\n",
                  name, result.mesh.element_count(), result.response.solver.unknowns,
                  report::number(result.mass.value_or(0)), result.symmetry_defect,
                  report::text(result.compliance, mm_newton)));
  return {{"file", link_file.string()},
          {"compliance", io::to_json(result.compliance)},
          {"mass", result.mass.value_or(0)}};
}

// 2. Stiffness of the manipulator at the five points of MMT11 and NONPERF.
struct Point {
  const char* name;
  double x, y, z;  // [mm]
};
constexpr Point points[] = {{"Q0", 0, 0, 0},
                            {"Q1", 126.35, 126.35, 126.35},
                            {"Q2", -73.65, -73.65, -73.65},
                            {"Q3", 126.35, 126.35, -73.65},
                            {"Q4", -73.65, -73.65, 126.35}};

struct PointResult {
  spatial::EigenStiffness unloaded;
  spatial::EigenStiffness loaded;
  spatial::Wrench wrench;  // that holds the platform 0.5 mm away along each axis
  bool stable = false;
};

PointResult evaluate_point(const vjm::Robot& robot, const Point& point) {
  const vjm::PostureResult posture =
      posture_at(robot.manipulator,
                 spatial::Pose::translation(1e-3 * spatial::Vector3(point.x, point.y, point.z)));
  if (!posture.reached) throw common::NoConvergence(posture.reason);
  const vjm::UnloadedStiffness unloaded = unloaded_stiffness(robot.manipulator, posture.posture);
  const spatial::Vector6 shift{5e-4, 5e-4, 5e-4, 0, 0, 0};
  const vjm::Equilibrium loaded = equilibrium_at_pose(
      robot.manipulator, posture.posture, spatial::displaced(posture.posture.platform, shift));
  if (loaded.status != vjm::EquilibriumStatus::converged)
    throw common::NoConvergence(loaded.reason);
  return {spatial::eigen_stiffness(unloaded.compliance.value()),
          spatial::eigen_stiffness(loaded.compliance.value()), loaded.wrench, loaded.held.stable()};
}

std::vector<std::string> table_row(const Point& point, const char* links, const PointResult& r) {
  const auto newton_per_mm = [](double v) { return report::number(1e-3 * v, 4); };
  return {point.name,
          links,
          newton_per_mm(r.unloaded.translation.minCoeff()),
          newton_per_mm(r.unloaded.translation.maxCoeff()),
          report::number(r.unloaded.rotation.minCoeff(), 4),
          newton_per_mm(r.loaded.translation.minCoeff()),
          newton_per_mm(r.loaded.translation.maxCoeff()),
          report::number(r.loaded.rotation.minCoeff(), 4),
          report::number(r.wrench.force.x(), 4),
          report::number(r.wrench.force.y(), 4),
          report::number(r.wrench.force.z(), 4),
          r.stable ? "yes" : "NO"};
}

io::Json point_json(const Point& point, const char* links, const PointResult& r) {
  const auto eigen = [](const spatial::EigenStiffness& e) {
    return io::Json{{"translation", io::to_json(e.translation)},
                    {"rotation", io::to_json(e.rotation)}};
  };
  return {{"point", point.name},
          {"links", links},
          {"unloaded", eigen(r.unloaded)},
          {"loaded", eigen(r.loaded)},
          {"wrench", io::to_json(r.wrench)},
          {"stable", r.stable}};
}

io::Json compare_link_models(const path& folder, Run& run) {
  const path robot_file = folder / "robots" / "orthoglide_fea.yaml";
  io::write_atomically(robot_file, io::read_text(shipped("data/robots/orthoglide_fea.yaml")));
  const vjm::Robot beams = vjm::read_robot(shipped("data/robots/orthoglide.yaml"));
  const vjm::Robot identified = vjm::read_robot(robot_file);
  report::Table table({"point", "links", "soft", "stiff", "turn", "soft*", "stiff*", "turn*", "Fx*",
                       "Fy*", "Fz*", "stable*"});
  io::Json json = io::Json::array();
  double done = 0;
  for (const Point& point : points) {
    for (const auto& [name, robot] : {std::pair("beam", &beams), std::pair("FEA", &identified)}) {
      const PointResult result = evaluate_point(*robot, point);
      table.add_row(table_row(point, name, result));
      json.push_back(point_json(point, name, result));
    }
    run.progress().report("stiffness", ++done / std::size(points));
  }
  run.print(
      "3-PUU at five points, links as the effective beams of the papers and from the meshes "
      "above:\n" +
      table.text() +
      "  soft, stiff: smallest and largest translational eigen-stiffness [N/mm]; turn: smallest\n"
      "  rotational one [N m/rad]; *: held 0.5 mm away along each axis, by the force F [N].\n\n");
  return json;
}

// 3. A bench robot against real readings.
io::Json compare_with_readings(Run& run) {
  const vjm::Robot bench = vjm::read_robot(shipped("data/robots/bench.yaml"));
  const calibration::Campaign campaign = calibration::read_campaign(
      shipped("data/measurements/nist_load_cell/campaign.yaml"), bench.manipulator);
  const calibration::Comparison comparison =
      calibration::compare(bench, campaign, run.threads(), run.progress());
  run.print(report::text(campaign, comparison));
  if (comparison.fitted && comparison.fitted->lack_of_fit) {
    const calibration::LackOfFitTest& test = *comparison.fitted->lack_of_fit;
    run.print(fmt::format(
        "\nThe linear spring {}: lack-of-fit F = {:.4g}, and {:.4g} is the limit at 5 %.\n",
        test.f > test.critical ? "FAILS, however well it seems to fit" : "is adequate", test.f,
        test.critical));
  }
  return report::to_json(campaign, comparison);
}

// 4. A campaign with a hidden effect: compare, diagnose, adopt, compare.
io::Json find_hidden_effect(const path& folder, Run& run) {
  const path source = shipped("data/measurements/orthoglide_clearance");
  const path designed = folder / "robots" / "measured.yaml", better = folder / "robots/better.yaml";
  io::write_atomically(designed, io::read_text(source / "robot.yaml"));
  const vjm::Robot robot = vjm::read_robot(designed);
  const calibration::Campaign campaign =
      calibration::read_campaign(source / "campaign.yaml", robot.manipulator);
  calibration::DiagnosisOptions options;
  if (run.wants_page()) options.profiles = most_profiles;
  const calibration::Diagnosis diagnosis =
      calibration::diagnose(robot, campaign, options, run.threads(), run.progress());
  run.print(report::text(robot, campaign, diagnosis));
  io::Json json = diagnosis_result(robot, campaign, options, diagnosis);
  const path diagnosis_file = folder / "diagnosis.json";
  io::write_json(diagnosis_file, json);
  run.print("\n5. Adopted: the error falls\n--------------------------\n");
  (void)adopt_effect(designed, diagnosis_file, "", false, better, run);
  const calibration::BeforeAfter both = calibration::compare_before_after(
      robot, vjm::read_robot(better), campaign, run.threads(), run.progress());
  run.print(report::waterfall_text(campaign, both.stages, both.held_out));
  if (run.wants_page()) {
    io::Json shown = json;
    shown["command"] = "diagnose";
    run.add_to_page({.result = std::move(shown),
                     .picture = diagnosis_picture(robot, campaign, both.before, &both.after),
                     .text = report::text(robot, campaign, diagnosis)});
  }
  json["after_adoption"] = report::to_json(campaign, both)["waterfall"];
  return json;
}

io::Json demo(const Request& request, Run& run) {
  const path folder = request.folder;
  io::Json json;
  run.print("1. Links, from their meshes\n---------------------------\n");
  for (const char* name : {"foot", "bar"}) json["links"][name] = identify_link(name, folder, run);
  run.print("2. The manipulator\n------------------\n");
  json["points"] = compare_link_models(folder, run);
  run.print("3. A model against measurements\n-------------------------------\n");
  json["comparison"] = compare_with_readings(run);
  run.print(
      "\n4. Which effect is missing from a model?\n----------------------------------------\n");
  json["hidden_effect"] = find_hidden_effect(folder, run);
  run.print(fmt::format("\nLink files, displacement fields (VTU) and the robot files are in {}\n",
                        folder.string()));
  return json;
}

}  // namespace

void add_demo(Program& program) {
  const auto request = std::make_shared<Request>();
  OptionList app = program.add({.name = "demo",
                                .summary = "End to end on the shipped Orthoglide: meshes, "
                                           "stiffness, measurements, the missing effect",
                                .example = "kinetostat demo"},
                               [request](Run& run) { return demo(*request, run); });
  app.add_option("--folder", request->folder, "Where results go").type_name("DIR").show_default();
}

}  // namespace kinetostat::apps
