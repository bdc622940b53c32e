// Names that mean something to the programs that files are written for.
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/fea/link/calculix_deck.h"
#include "kinetostat/fea/link/gmsh_export.h"
#include "kinetostat/fea/link/matrix_export.h"
#include "kinetostat/io/vtu.h"

namespace kinetostat::fea::export_names_test {
namespace {

using testing::HasSubstr;
using testing::Not;

const std::string evil = "*INCLUDE, INPUT=/etc/passwd\n*INCLUDE, INPUT=x\r\x1b[2J\"'); quit %";

// One tetrahedron, held at one face and loaded at another.
struct Tetrahedron {
  Tetrahedron() {
    mesh.nodes = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    mesh.connectivity = {0, 1, 2, 3};
    mesh.boundary = {{.nodes = {0, 2, 1}, .tag = 1}, {.nodes = {0, 1, 3}, .tag = 2}};
    for (const int tag : {1, 2})
      interfaces.push_back({.name = evil, .geometry = interface_on(mesh, tag), .point = {}});
  }
  TetMesh mesh;
  std::vector<CoupledInterface> interfaces;
};

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> all;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) all.push_back(line);
  return all;
}

TEST(ExportNames, AreNoKeywordsOfADeck) {
  const Tetrahedron one;
  const std::vector<Material> materials{Material(210e9, 0.3)};
  const std::string long_name = std::string(1319, 'x') + "*INCLUDE, INPUT=/etc/passwd";
  for (const std::string& title : {evil, std::string("*INCLUDE, INPUT=x"), long_name}) {
    const std::string deck = calculix_deck(title, one.mesh, materials, one.interfaces);
    for (const std::string& line : lines_of(deck)) {
      EXPECT_LT(line.size(), 1320u);  // CalculiX cuts there
      EXPECT_FALSE(line.starts_with("*INCLUDE")) << line;
    }
    EXPECT_THAT(deck, Not(HasSubstr("\r")));
    EXPECT_THAT(deck, Not(HasSubstr("\x1b")));
  }
}

TEST(ExportNames, StayInTheirQuotesInAMesh) {
  const Tetrahedron one;
  for (const std::string& line : lines_of(gmsh_mesh(one.mesh, one.interfaces)))
    if (line.find('"') != std::string::npos) {
      EXPECT_EQ(std::count(line.begin(), line.end(), '"'), 2) << line;
      EXPECT_TRUE(line.ends_with('"')) << line;
    }
}

TEST(ExportNames, StayInTheirQuotesInMatlab) {
  Tetrahedron one;
  LinkResult result(evil, {Material(210e9, 0.3)});
  result.interfaces = one.interfaces;
  result.response.flexibility = Eigen::MatrixXd::Identity(6, 6);
  const std::string script = flexibility_matlab(result);
  EXPECT_THAT(script, Not(HasSubstr("\r")));
  EXPECT_THAT(script,
              HasSubstr("\nname = '*INCLUDE, INPUT=/etc/passwd?*INCLUDE, INPUT=x??[2J\"''); "
                        "quit %';\n"));
  // Outside of the quotes nothing of the names is left.
  bool quoted = false;
  std::string outside;
  for (const char c : script) {
    if (c == '\'') quoted = !quoted;
    if (!quoted) outside += c;
  }
  EXPECT_FALSE(quoted);
  EXPECT_THAT(outside, Not(HasSubstr("quit")));
}

TEST(ExportNames, AreNoFormulasInATable) {
  Tetrahedron one;
  one.interfaces[1].name = "=cmd|' /C calc'!A0";
  LinkResult result("link", {Material(210e9, 0.3)});
  result.interfaces = one.interfaces;
  result.response.flexibility = Eigen::MatrixXd::Identity(6, 6);
  const std::string table = flexibility_csv(result);
  EXPECT_THAT(table, Not(HasSubstr(",=")));
  EXPECT_THAT(table, Not(HasSubstr("\n=")));
}

TEST(ExportNames, AreXmlForParaView) {
  const io::VtuGrid grid{.points = {0, 0, 0},
                         .cell = io::VtuCell::vertex,
                         .nodes_per_cell = 1,
                         .connectivity = {0},
                         .point_fields = {{.name = evil, .values = {1}}}};
  const std::string text = io::vtu_text(grid);
  EXPECT_THAT(text, Not(HasSubstr("\x1b")));
  EXPECT_THAT(text, HasSubstr("&quot;"));
}

}  // namespace
}  // namespace kinetostat::fea::export_names_test
