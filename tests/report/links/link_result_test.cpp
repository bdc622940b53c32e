#include "kinetostat/report/links/link_result.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/fea/link/gmsh_export.h"
#include "kinetostat/io/link_result_file.h"

#include "fea/shapes.h"

namespace kinetostat::report::link_result_test {
namespace {

using io::Json;
using testing::HasSubstr;

// A bar of 100 x 20 x 12 mm along x as a volume mesh, held at one end and loaded at the other.
class LinkResultJson : public testing::Test {
 protected:
  fea::LinkResult identified(const std::string& material) const {
    const fea::TetMesh mesh = fea::box_mesh({0.1, 0.02, 0.012}, 8, 2, 2);
    (void)folder_.file("bar.msh", fea::gmsh_mesh(mesh, fea::coupled_ends(mesh)));
    const fea::LinkSpec link = fea::read_link(
        folder_.file("bar.yaml",
                     "kinetostat: 1\nlink: bar\nmesh: {file: bar.msh, unit: m}\n"
                     "material: {" +
                         material +
                         "}\n"
                         "fixed: {plane: {point: [0, 0, 0], normal: [-1, 0, 0]}}\n"
                         "loaded: {plane: {point: [0.1, 0, 0], normal: [1, 0, 0]}}\n"));
    common::Progress silent;
    return fea::identify(link, fea::read_geometry(link, silent), {}, silent);
  }
  std::filesystem::path written(const fea::LinkResult& result) const {
    const std::filesystem::path file = folder_.path() / "bar.link.json";
    io::write_json(file, to_json(result));
    return file;
  }
  static constexpr const char* steel = "E: 210 GPa, nu: 0.3, density: 7850 kg/m^3";

 private:
  test::TemporaryFolder folder_;
};

TEST_F(LinkResultJson, SameInputSameBytesApartFromTimings) {
  const auto bytes = [this] {
    Json json = to_json(identified(steel));
    json.erase("timings");
    return io::to_text(json);
  };
  EXPECT_EQ(bytes(), bytes());
}

TEST_F(LinkResultJson, IsReadAsTheSameLink) {
  const fea::LinkResult result = identified(steel);
  const io::IdentifiedLink read = io::read_identified_link(written(result));
  EXPECT_EQ(read.compliance.matrix(), result.compliance.matrix());
  EXPECT_EQ(read.compliance.frame().point, result.compliance.frame().point);
  EXPECT_EQ(read.mass, result.mass);
  EXPECT_NEAR(*read.mass, 7850 * 0.1 * 0.02 * 0.012, 1e-9);
  EXPECT_EQ(read.center_of_mass, result.center_of_mass);
  EXPECT_EQ(read.mesh_sha256, result.mesh_sha256);
  EXPECT_EQ(read.mesh_sha256.size(), 64u);
}

TEST_F(LinkResultJson, HasNoMassWithoutADensity) {
  EXPECT_EQ(io::read_identified_link(written(identified("E: 210 GPa, nu: 0.3"))).mass,
            std::nullopt);
}

TEST_F(LinkResultJson, HasTheKeysOfTheReference) {
  const Json json = to_json(identified(steel));
  for (const char* key : {"compliance", "order", "point", "axes", "units", "symmetry_defect",
                          "eigen_stiffness", "mass", "center_of_mass", "mesh", "timings", "inputs"})
    EXPECT_TRUE(json.contains(key)) << key;
}

TEST_F(LinkResultJson, OfAnotherLinkFileDiffersInItsHashAlone) {
  const Json json = to_json(identified(steel));
  Json other = with_link_file(json, "abc");
  EXPECT_EQ(other["inputs"]["link_sha256"], "abc");
  other["inputs"]["link_sha256"] = json["inputs"]["link_sha256"];
  EXPECT_EQ(other, json);
}

TEST_F(LinkResultJson, TextSaysWhatTheJsonHas) {
  const fea::LinkResult result = identified(steel);
  const std::string words = text(result);
  EXPECT_THAT(words, HasSubstr("mass 0.1884 kg, centre of mass [0.05, 0.01, 0.006] m"));
  EXPECT_THAT(words, HasSubstr("Compliance at point (0.1, 0.01, 0.006) m"));
  EXPECT_THAT(words, HasSubstr("the lower bound"));
}

}  // namespace
}  // namespace kinetostat::report::link_result_test
