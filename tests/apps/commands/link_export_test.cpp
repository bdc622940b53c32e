// The files that identify writes for other programs.
#include <cstdlib>
#include <fstream>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/io/csv.h"
#include "kinetostat/io/json.h"
#include "kinetostat/io/text_file.h"

#include "apps/run_program.h"
#include "support/program.h"

namespace kinetostat::link_export_test {
namespace {

using test::kinetostat;
using test::working_folder;
using testing::HasSubstr;

// A coarse bar, identified once with all exports.
class LinkExport : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    std::string text = io::read_text(working_folder() / "meshes/test_bar.yaml");
    text.replace(text.find("size: 3"), 7, "size: 8");
    text.replace(text.find("test_bar.stl"), 12, "meshes/test_bar.stl");
    std::ofstream(working_folder() / "coarse.yaml") << text;
    const test::Outcome outcome = kinetostat(
        "identify coarse.yaml -o coarse.json --deck coarse.inp --msh coarse.msh --csv coarse.csv "
        "--matlab coarse.m");
    ASSERT_EQ(outcome.code, 0) << outcome.err;
  }
  static std::string text(const char* file) { return io::read_text(working_folder() / file); }
  static io::Json result() { return io::read_json(working_folder() / "coarse.json"); }
};

TEST_F(LinkExport, TableHoldsTheCompliance) {
  const io::CsvTable table = io::read_csv(working_folder() / "coarse.csv");
  ASSERT_EQ(table.rows(), 6u);
  EXPECT_EQ(table.columns()[2], "loaded.Fy");
  EXPECT_EQ(table.cell(5, 0), "loaded.rz");
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t j = 0; j < 6; ++j)
      EXPECT_EQ(table.number(i, j + 1), result()["compliance"][i][j].get<double>());
}

TEST_F(LinkExport, MatlabScriptDefinesTheMatrices) {
  const std::string script = text("coarse.m");
  EXPECT_THAT(script, HasSubstr("name = 'test bar';"));
  EXPECT_THAT(script, HasSubstr("'loaded.Mz'};"));
  EXPECT_THAT(script, HasSubstr("points = [0.31 0 0];"));
  std::istringstream rows(script.substr(script.find("flexibility = [") + 15));
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) {
      double value = 0;
      ASSERT_TRUE(rows >> value);
      EXPECT_EQ(value, result()["compliance"][i][j].get<double>());
    }
}

TEST_F(LinkExport, MeshHasTheSizeThatIsReportedAndGmshReadsIt) {
  const std::string mesh = text("coarse.msh");
  const auto nodes = std::to_string(result()["mesh"]["nodes"].get<int>());
  EXPECT_THAT(mesh, HasSubstr("$Nodes\n" + nodes + "\n"));
  EXPECT_THAT(mesh, HasSubstr("\"fixed\"\n2 2 \"loaded\"\n3 3 \"link\"\n"));
  ASSERT_TRUE(test::is_installed("gmsh"));
  // Gmsh computes the volume of the elements: wrongly ordered mid nodes would bend them.
  std::ofstream(working_folder() / "volume.geo")
      << "Merge \"coarse.msh\";\nPlugin(MeshVolume).PhysicalGroup = 3;\n"
         "Plugin(MeshVolume).Dimension = 3;\nPlugin(MeshVolume).Run;\n";
  const std::string call =
      "cd '" + working_folder().string() + "' && gmsh volume.geo -0 -o unused.msh > gmsh.log 2>&1";
  EXPECT_EQ(std::system(call.c_str()), 0) << text("gmsh.log");
  const std::string log = text("gmsh.log");
  EXPECT_THAT(log, testing::Not(HasSubstr("Error")));
  EXPECT_THAT(log, HasSubstr("7.44e-05"));  // 310 x 20 x 12 mm
}

TEST_F(LinkExport, DeckSaysWhereItsResultsAre) {
  EXPECT_THAT(text("coarse.inp"),
              HasSubstr("loaded loaded: rigid coupling, translation of its point at node"));
}

TEST_F(LinkExport, FolderThatCannotBeWrittenToIsNamed) {
  const test::Outcome outcome = kinetostat("identify coarse.yaml --csv CONTRIBUTING.md/x.csv");
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("CONTRIBUTING.md"));
}

// The printed bar of the last diagonal entry of each is that of the result file.
TEST(PrintedBars, AreThoseOfEveryLoadedInterface) {
  std::string text = io::read_text(working_folder() / "meshes/ternary_link.yaml");
  text.replace(text.find("ternary_link.stl"), 16, "meshes/ternary_link.stl");
  text.replace(text.find("{accuracy: 1 %}"), 15, "{size: 10}");
  std::ofstream(working_folder() / "ternary.yaml") << text;
  const test::Outcome outcome =
      kinetostat("identify ternary.yaml -o ternary.json --no-cache --bracket never --verbose");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const std::string bars = outcome.out.substr(outcome.out.find("error bars"));
  const io::Json result = io::read_json(working_folder() / "ternary.json");
  for (std::size_t k = 0; k < 2; ++k) {
    const std::size_t table = bars.find(k == 0 ? "at side:" : "at apex:");
    ASSERT_NE(table, std::string::npos);
    std::istringstream row(bars.substr(bars.find("rz", table) + 2));
    double last = 0;
    for (std::string cell; row.peek() != '\n' && row >> cell;) last = std::atof(cell.c_str());
    const std::size_t i = 6 * k + 5;
    const double bar = result["error"]["bar"][i][i], entry = result["reduced"]["flexibility"][i][i];
    EXPECT_NEAR(last, 100 * bar / entry, 0.06 * last);  // printed to two digits
  }
}

}  // namespace
}  // namespace kinetostat::link_export_test
