#include "fuzz/readers.h"

#include <cmath>
#include <cstdio>
#include <memory>
#include <zlib.h>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/commands/commands.h"
#include "kinetostat/calibration/campaign/campaign.h"
#include "kinetostat/calibration/campaign/campaign_file.h"
#include "kinetostat/calibration/design/plan_score.h"
#include "kinetostat/calibration/diagnosis/diagnosis.h"
#include "kinetostat/calibration/search/candidate_fitter.h"
#include "kinetostat/calibration/search/fit_record.h"
#include "kinetostat/fea/link/link_file.h"
#include "kinetostat/fea/mesh/surface_import.h"
#include "kinetostat/fea/mesh/volume_mesh.h"
#include "kinetostat/fea/surface/surface_check.h"
#include "kinetostat/fea/surface/surface_mesh.h"
#include "kinetostat/io/base64.h"
#include "kinetostat/io/cache.h"
#include "kinetostat/io/csv.h"
#include "kinetostat/io/link_result_file.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/io/yaml.h"
#include "kinetostat/report/page.h"
#include "kinetostat/report/plan.h"
#include "kinetostat/vjm/effects/kinds/expression.h"
#include "kinetostat/vjm/exchange/description_file.h"
#include "kinetostat/vjm/exchange/robot_import.h"
#include "kinetostat/vjm/exchange/urdf_import.h"
#include "kinetostat/vjm/io/robot_file.h"
#include "kinetostat/vjm/workspace/map_checkpoint.h"

#include "support/zip_writer.h"

namespace kinetostat::fuzz {
namespace {

using common::InputError;
using io::read_text;
using std::filesystem::path;

const path source = KINETOSTAT_SOURCE_DIR;
const path corpus = source / "tests/fuzz/corpus";

std::vector<std::string> texts(const path& folder, const std::string& ending) {
  std::vector<path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (entry.path().string().ends_with(ending)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  std::vector<std::string> all;
  for (const path& file : files) all.push_back(read_text(file));
  return all;
}

std::vector<std::string> joined(std::vector<std::string> a, const std::vector<std::string>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

// Files of this test come and go thousands of times: without waiting for the disk.
void put(const path& file, const std::string& bytes) {
  io::write_atomically(file, bytes, io::Flush::no);
}

// Every value of a YAML file, in every way that it can be asked for.
void walk(const io::YamlNode& node) {
  if (node.is_map())
    for (const auto& [key, value] : node.members()) walk(value);
  if (node.is_sequence())
    for (const io::YamlNode& item : node.items()) walk(item);
  if (!node.is_scalar()) return;
  try {
    if (!std::isfinite(node.number())) throw Wrong("a number that is none");
  } catch (const InputError&) {  // most are no numbers
  }
}

Reader yaml_reader(const path& folder) {
  return {
      .name = "yaml",
      .sound = joined(texts(source / "data/robots", ".yaml"), texts(source / "meshes", ".yaml")),
      .others = {"a: &a [1, 2]\nb: *a\n? [c]\n: !!str d\n--- {e: |\n  f}\n"},
      .read = [file = folder / "any.yaml"](const std::string& bytes) {
        const io::YamlNode top = io::parse_yaml(bytes, file);
        walk(top);
        (void)io::meaning(top);
      }};
}

Reader robot_reader(const path& folder) {
  return {.name = "robot",
          .sound = joined(texts(source / "data/robots", ".yaml"),
                          {read_text(source / "tests/tree/full_robot.yaml")}),
          .read = [file = folder / "data/robots/any.yaml"](const std::string& bytes) {
            put(file, bytes);
            (void)vjm::read_robot(file);
          }};
}

Reader link_reader(const path& folder) {
  return {.name = "link",
          .sound = texts(source / "meshes", ".yaml"),
          .read = [file = folder / "meshes/any.yaml"](const std::string& bytes) {
            put(file, bytes);
            (void)fea::read_link(file);
          }};
}

// A campaign in a folder of its own, of which one file is given.
Reader campaign_reader(const path& folder, const std::string& name, const std::string& file) {
  const path measured = folder / "data/measurements" / name;
  const auto robot = std::make_shared<vjm::Robot>(vjm::read_robot(measured / "robot.yaml"));
  return {.name = file == "readings.csv" ? "readings" : "campaign",
          .sound = {read_text(measured / file)},
          .others = joined(texts(source / "data/measurements/nist_load_cell", file),
                           texts(source / "data/starters", file)),
          .read = [measured, robot, file](const std::string& bytes) {
            put(measured / file, bytes);
            (void)calibration::read_campaign(measured / "campaign.yaml", robot->manipulator);
          }};
}

Reader table_reader(const path& folder) {
  return {.name = "table",
          .sound = joined(texts(source / "data/paths", ".csv"),
                          texts(source / "data/measurements/plans", ".csv")),
          .others = {"\xef\xbb\xbf\"a\";\"b \"\"c\"\"\"\r\n\"1\n2\";'=x\r\n"},
          .read = [file = folder / "any.csv"](const std::string& bytes) {
            const io::CsvTable table(bytes, file);
            for (std::size_t row = 0; row < table.rows(); ++row)
              for (std::size_t column = 0; column < table.columns().size(); ++column)
                if (!table.empty(row, column) && !std::isfinite(table.number(row, column)))
                  throw Wrong("a number that is none");
          }};
}

Reader workbook_reader(const path& folder) {
  const std::string rows =
      "<row r=\"1\"><c r=\"A1\" t=\"s\"><v>0</v></c><c r=\"B1\" t=\"inlineStr\"><is><t>dz "
      "[um]</t></is>"
      "</c></row><row r=\"2\"><c r=\"A2\" s=\"1\"><v>46145.5</v></c><c r=\"B2\"><v>2</v></c></row>";
  const auto excel = [](const std::string& sheet) {
    return test::xlsx_of({{"a", sheet}}, {"time"}, {"yyyy-mm-dd"});
  };
  return {
      .name = "workbook",
      .sound = {excel(rows),
                test::ods_of("<table:table table:name=\"a\"><table:table-row><table:table-cell>"
                             "<text:p>fx</text:p></table:table-cell><table:table-cell><text:p>dz"
                             "</text:p></table:table-cell></table:table-row><table:table-row "
                             "table:number-rows-repeated=\"3\"><table:table-cell "
                             "table:number-columns-repeated=\"2\" office:value-type=\"float\" "
                             "office:value=\"1\"/></table:table-row></table:table>")},
      .read =
          [file = folder / "any.xlsx"](const std::string& bytes) {
            put(file, bytes);
            (void)io::read_table(file);
          },
      .sealed = excel,
      .contents = {rows}};
}

Reader compliance_reader(const path& folder) {
  return {.name = "link_result",
          .sound = texts(source / "data/links", ".json"),
          .read = [file = folder / "any.json"](const std::string& bytes) {
            put(file, bytes);
            (void)io::to_text(io::read_json(file));
            // Of three interfaces and more there is none.
            const bool finite = bytes.find("\"compliance\"") == std::string::npos
                                    ? io::read_reduced_link(file).stiffness.allFinite()
                                    : io::read_compliance(file).matrix().allFinite();
            if (!finite) throw Wrong("a matrix that is not finite");
          }};
}

const std::vector<std::string>& small_results() {
  static const std::vector<std::string> all{
      R"([{"result": {"tool": "kinetostat 0.1.0", "command": "stiffness", "x": [1, 2.5, null]},
          "picture": {"readings": {"a": [[1, 2], [3, 4]]}}, "text": "all is well\n"}])",
      R"([{"result": {"path": {"branches": [{"points": [{"equilibrium": 1}]}],
          "critical_points": [], "at_target": []}}, "picture": null, "text": ""}])"};
  return all;
}

std::string deflated(const std::string& text) {
  uLongf size = compressBound(text.size());
  std::string bytes(size, '\0');
  compress2(reinterpret_cast<Bytef*>(bytes.data()), &size,
            reinterpret_cast<const Bytef*>(text.data()), text.size(), 6);
  bytes.resize(size);
  return bytes;
}

std::string page_of(const std::string& results) {
  return "<!doctype html>\n<script type=\"application/octet-stream\" id=\"results\">" +
         io::base64(deflated(results)) + "</script>\n";
}

Reader page_reader(const path& folder) {
  return {.name = "page",
          .sound = {page_of(small_results()[0]), page_of(small_results()[1])},
          .read =
              [file = folder / "any.html"](const std::string& bytes) {
                put(file, bytes);
                const auto results = report::read_page_results(file);
                if (report::has_pages()) (void)report::page("title", results);
              },
          .sealed = page_of,
          .contents = small_results()};
}

Reader checkpoint_reader(const path& folder) {
  const vjm::MapCheckpoint map{.file = folder / "map.part", .request = "abc"};
  std::vector<vjm::MapPoint> points(20);
  for (std::size_t i = 0; i < points.size(); ++i)
    points[i] = {vjm::MapState::reached, {0.1 * static_cast<double>(i), -1e-300}};
  vjm::write_map_checkpoint(map, points, 30);
  const std::string sound = read_text(map.file);
  const std::size_t begin = sound.find('\n', sound.find('\n') + 1) + 1;
  const std::string head = sound.substr(0, begin);
  const std::string request = head.substr(head.find('\n') + 1, head.size() - head.find('\n') - 2);
  return {.name = "checkpoint",
          .sound = {sound},
          .read =
              [map](const std::string& bytes) {
                put(map.file, bytes);
                if (vjm::read_map_checkpoint(map, 30, 2).size() > 30)
                  throw Wrong("more poses than the map has");
              },
          .sealed =
              [head, request](const std::string& content) {
                return head + io::sha256(request + "\n" + content) + "\n" + content;
              },
          .contents = {sound.substr(sound.find('\n', begin) + 1)}};
}

// What is found is what was kept, or nothing.
Reader cache_reader(const path& folder) {
  const auto cache = std::make_shared<io::Cache>(folder / "cache");
  const std::string content = "what was kept\n";
  cache->keep("key", content);
  const path entry = std::filesystem::directory_iterator(folder / "cache")->path();
  return {.name = "cache", .sound = {read_text(entry)}, .read = [=](const std::string& bytes) {
            put(entry, bytes);
            if (const auto found = cache->find("key"); found && *found != content)
              throw Wrong("another content than was kept");
          }};
}

Reader record_reader() {
  calibration::BaseFit fit;
  fit.predicted.resize(2, spatial::Vector6::Ones());
  fit.weak = {"a", "b"};
  return {.name = "fit_record",
          .sound = {calibration::record_of(fit),
                    calibration::record_of(calibration::CandidateFitter::Signatures{})},
          .others = {calibration::record_of(common::NotIdentifiable("cannot be told"))},
          .read = [](const std::string& bytes) {
            (void)calibration::recorded_fit(bytes, {});
            (void)calibration::recorded_signatures(bytes, {});
          }};
}

// The program's own exit codes say what it took for a fault of its own.
void run_quietly(apps::Program& program, const std::vector<const char*>& arguments) {
  const int code = program.run(static_cast<int>(arguments.size()), arguments.data());
  if (code == apps::failure || code == apps::out_of_memory || code > apps::out_of_memory)
    throw Wrong("the program ended with " + std::to_string(code));
  if (code != apps::done) throw InputError("input", "was refused");
}

Reader diagnosis_reader(const path& folder) {
  const path robot = folder / "data/robots/bench.yaml";
  io::Json sound = io::read_json(corpus / "diagnosis.json");
  sound["inputs"]["robot"]["sha256"] = io::sha256(read_text(robot));
  return {.name = "diagnosis",
          .sound = {io::to_text(sound)},
          .read = [robot, file = folder / "diagnosis.json",
                   out = folder / "data/robots/adopted.yaml"](const std::string& bytes) {
            put(file, bytes);
            const std::shared_ptr<std::FILE> nowhere(std::fopen("/dev/null", "w"), std::fclose);
            apps::Program program({nowhere.get(), nowhere.get()});
            apps::add_adopt(program);
            const std::string robot_name = robot.string(), name = file.string(),
                              out_name = out.string();
            run_quietly(program, {"kinetostat", "adopt", robot_name.c_str(), name.c_str(), "-o",
                                  out_name.c_str()});
          }};
}

Reader plan_reader(const path& folder) {
  return {.name = "plan",
          .sound = {R"({"splits": [{"a": "nominal", "b": "clearance at x", "nats": 3.5,
                                   "log_evidence_difference_so_far": 0.5}],
                       "sharpened": []})"},
          .read = [file = folder / "plan.json"](const std::string& bytes) {
            put(file, bytes);
            const vjm::Robot robot = vjm::read_robot(source / "data/robots/bench.yaml");
            io::Json plan = io::read_json(file);
            if (plan.is_object()) plan["sharpened"] = io::Json::array();  // needs a fit
            common::Progress silent;
            (void)calibration::score_plan(report::promise_of(plan, file), robot, {}, {}, 1, silent);
          }};
}

Reader surface_reader(const path& folder, const std::string& kind) {
  return {.name = kind,
          .sound = texts(corpus, "." + kind),
          .read = [file = folder / ("any." + kind)](const std::string& bytes) {
            put(file, bytes);
            const fea::ImportedSurface surface = fea::read_surface(file, "mm");
            (void)fea::check_surface(surface.mesh, surface.weld.tolerance);
          }};
}

Reader volume_reader(const path& folder, const std::string& kind) {
  return {.name = kind + "_volume",
          .sound = texts(corpus, "." + kind),
          .read = [file = folder / ("volume." + kind)](const std::string& bytes) {
            put(file, bytes);
            if (fea::holds_volume_mesh(file)) (void)fea::read_volume_mesh(file, "mm");
          }};
}

Reader urdf_reader(const path& folder) {
  return {.name = "urdf",
          .sound = texts(source / "data/urdf", ".urdf"),
          .read = [file = folder / "any.urdf"](const std::string& bytes) {
            put(file, bytes);
            const vjm::RobotDescription model = vjm::read_urdf(file);
            const vjm::ImportedRobot robot =
                vjm::import_robot(model, vjm::find_chain(model, "", "flange"));
            try {
              (void)io::parse_yaml(robot.text, "imported.yaml");
            } catch (const InputError& error) {
              throw Wrong(std::string("an imported robot that is no YAML: ") + error.what());
            }
          }};
}

// The other descriptions of robots, each by its extension.
Reader description_reader(const path& folder, const std::string& extension) {
  return {.name = "description" + extension,
          .sound = texts(source / "data/urdf", extension),
          .read = [file = folder / ("any" + extension)](const std::string& bytes) {
            put(file, bytes);
            const vjm::RobotDescription robot = vjm::read_robot_description(file);
            const vjm::ImportedRobot made =
                vjm::import_robot(robot, vjm::find_chain(robot, "", ""));
            try {
              (void)io::parse_yaml(made.text, "imported.yaml");
            } catch (const InputError& error) {
              throw Wrong(std::string("an imported robot that is no YAML: ") + error.what());
            }
          }};
}

Reader unit_reader() {
  return {.name = "unit",
          .sound = {"mm", "N*m/rad", "kg/m^3", "1/(N m)", "um", "GPa", "lbf*in/deg", "kN", "%"},
          .others = {"((", "^-99999", "**", "µm"},
          .read = [](const std::string& bytes) {
            try {
              (void)spatial::parse_unit(bytes);
            } catch (const std::invalid_argument& error) {
              throw InputError("unit", error.what());
            }
          }};
}

Reader quantity_reader() {
  return {.name = "quantity",
          .sound = {"12 mm", "1e-3m", "-0.5 inch", "inf m", "3 um"},
          .read = [](const std::string& bytes) {
            try {
              (void)spatial::parse_quantity(bytes, spatial::dimension::length);
            } catch (const std::invalid_argument& error) {
              throw InputError("quantity", error.what());
            }
          }};
}

Reader expression_reader() {
  return {.name = "expression",
          .sound = {"a * tanh(x / w)", "sin(x)^2 + 3*(x - a)^3/w", "-exp(-x*x)*_pi", "log2(a+2)"},
          .others = {"x ? a : w", "abs(x)", "((((((((((((", "x x", "1e", "sqrt()"},
          .read = [](const std::string& bytes) {
            try {
              const vjm::Expression formula(bytes, {"x", "a", "w"});
              const Eigen::Vector3d at(0.3, -2, 1e-3);
              (void)formula.value(at);
              for (Eigen::Index k = 0; k < 3; ++k) (void)formula.derivative(at, k);
              (void)formula.first_not_finite(at);
            } catch (const vjm::ExpressionError& error) {
              if (error.column < 1) throw Wrong("an error at no place");
              throw InputError("formula", error.what());
            }
          }};
}

// The shipped data, of which links would lead back to the source.
void lay_out(const path& folder) {
  constexpr auto all = std::filesystem::copy_options::recursive;
  std::filesystem::copy(source / "data", folder / "data", all);
  std::filesystem::copy(source / "meshes", folder / "meshes", all);
}

}  // namespace

std::vector<Reader> all_readers(const path& folder) {
  lay_out(folder);
  std::vector<Reader> all{yaml_reader(folder),
                          robot_reader(folder),
                          link_reader(folder),
                          campaign_reader(folder, "arm_thermal_day", "campaign.yaml"),
                          campaign_reader(folder, "arm_hysteresis", "readings.csv"),
                          table_reader(folder),
                          workbook_reader(folder),
                          compliance_reader(folder),
                          diagnosis_reader(folder),
                          plan_reader(folder),
                          page_reader(folder),
                          checkpoint_reader(folder),
                          cache_reader(folder),
                          record_reader(),
                          urdf_reader(folder),
                          description_reader(folder, ".sdf"),
                          description_reader(folder, ".xml"),
                          description_reader(folder, ".yaml"),
                          unit_reader(),
                          quantity_reader(),
                          expression_reader()};
  for (const char* kind : {"stl", "obj", "ply", "msh"}) all.push_back(surface_reader(folder, kind));
  for (const char* kind : {"msh", "inp"}) all.push_back(volume_reader(folder, kind));
  return all;
}

}  // namespace kinetostat::fuzz
