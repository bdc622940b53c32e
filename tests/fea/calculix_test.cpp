// The same tetrahedra solved by CalculiX, an independent program.
#include <cstdlib>
#include <sstream>

#include <gtest/gtest.h>

#include "kinetostat/files/text_file.h"

#include "fea/reference_bar.h"

namespace kinetostat::fea {
namespace {

std::string node_set(const char* name, const std::vector<int>& nodes) {
  std::ostringstream text;
  text << "*NSET, NSET=" << name << "\n";
  for (const int n : nodes) text << n + 1 << ",\n";
  return text.str();
}

// One step per wrench; REF takes the force, ROT the moment, both at the reference point.
std::string deck(const ReferenceBar& bar) {
  const TetMesh& mesh = bar.mesh;
  std::ostringstream text;
  text << std::scientific;
  text.precision(12);  // CalculiX reads fields of at most 20 characters
  const auto node = [&text](std::size_t number, const Vector3& p) {
    text << number << ", " << p.x() << ", " << p.y() << ", " << p.z() << "\n";
  };
  text << "*NODE, NSET=ALL\n";
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n) node(n + 1, mesh.nodes[n]);
  const std::size_t ref = mesh.nodes.size() + 1, rot = ref + 1;
  text << "*NODE, NSET=REF\n";
  node(ref, bar.tip);
  text << "*NODE, NSET=ROT\n";
  node(rot, bar.tip);
  text << "*ELEMENT, TYPE=C3D10, ELSET=SOLID\n";
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    text << e + 1;
    for (const int n : mesh.element(e)) text << ", " << n + 1;
    text << "\n";
  }
  text << node_set("ROOT", interface_on(mesh, 1).nodes)
       << node_set("TIP", interface_on(mesh, 2).nodes) << "*MATERIAL, NAME=STEEL\n*ELASTIC\n"
       << bar.steel.young() << ", " << bar.steel.poisson()
       << "\n*SOLID SECTION, ELSET=SOLID, MATERIAL=STEEL\n*RIGID BODY, NSET=TIP, REF NODE=" << ref
       << ", ROT NODE=" << rot << "\n*BOUNDARY\nROOT, 1, 3, 0.\n";
  for (int wrench = 0; wrench < 6; ++wrench)
    text << "*STEP\n*STATIC\n*CLOAD, OP=NEW\n"
         << (wrench < 3 ? ref : rot) << ", " << wrench % 3 + 1
         << ", 1.\n*NODE PRINT, NSET=REF\nU\n*NODE PRINT, NSET=ROT\nU\n*END STEP\n";
  return text.str();
}

// The .dat file lists, step by step, "node ux uy uz" for REF and then for ROT.
Matrix6 read_displacements(const std::string& dat) {
  Matrix6 c = Matrix6::Zero();
  std::istringstream lines(dat);
  int rows = 0;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    long node = 0;
    Vector3 u;
    if (!(words >> node >> u.x() >> u.y() >> u.z())) continue;
    if (rows < 12) c.block<3, 1>(3 * (rows % 2), rows / 2) = u;
    ++rows;
  }
  EXPECT_EQ(rows, 12);
  return c;
}

TEST(CalculiX, AgreesOnTheSameTetrahedraWithinATenthOfAPercent) {
  if (std::system("command -v ccx > /dev/null 2>&1") != 0)
    GTEST_SKIP() << "CalculiX (Debian package calculix-ccx) is not installed";
  const ReferenceBar bar(0.008);
  const TemporaryFolder folder;
  folder.file("bar.inp", deck(bar));
  const std::string call = "cd '" + folder.path().string() + "' && ccx bar > ccx.log 2>&1";
  ASSERT_EQ(std::system(call.c_str()), 0) << files::read_text(folder.path() / "ccx.log");
  const Matrix6 other = read_displacements(files::read_text(folder.path() / "bar.dat"));
  const Matrix6 ours = bar.compliance();
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) {
      const double size = std::sqrt(ours(i, i) * ours(j, j));
      // CalculiX prints seven digits.
      EXPECT_NEAR(ours(i, j), other(i, j), 1e-3 * std::abs(other(i, j)) + 1e-6 * size) << i << j;
    }
}

}  // namespace
}  // namespace kinetostat::fea
