// Meshes from elsewhere, as users meet them: `mesh check` with repair, and volume meshes as links.
#include <array>
#include <cmath>
#include <fstream>
#include <string>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/io/json.h"
#include "kinetostat/io/link_result_file.h"
#include "kinetostat/io/text_file.h"

#include "apps/run_program.h"

namespace kinetostat::mesh_command_test {
namespace {

using test::kinetostat;
using test::Outcome;
using test::working_folder;
using testing::HasSubstr;

void write(const std::string& name, const std::string& text) {
  std::ofstream(working_folder() / name, std::ios::binary) << text;
}

io::Json json(const std::string& name) { return io::read_json(working_folder() / name); }

// A cube of side 10 with one corner at (x, 0, 0), without its last `missing` facets.
std::string cube(const std::string& name, double x, int missing = 0, double slip = 0) {
  const int faces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                           {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  std::string text = "solid " + name + "\n";
  int count = 12 - missing;
  for (const auto& f : faces)
    for (const auto& t : {std::array{f[0], f[1], f[2]}, std::array{f[0], f[2], f[3]}}) {
      if (count-- <= 0) continue;
      text += "facet normal 0 0 0\n outer loop\n";
      for (const int i : t)
        text += fmt::format("  vertex {} {} {}\n", x + 10.0 * (i & 1) + slip * count,
                            10.0 * (i >> 1 & 1), 10.0 * (i >> 2 & 1));
      text += " endloop\nendfacet\n";
    }
  return text + "endsolid " + name + "\n";
}

TEST(MeshCommand, RepairIsReportedAndTheResultIsSound) {
  write("seams.stl", cube("a", 0, 0, 1e-5));
  EXPECT_EQ(kinetostat("mesh check seams.stl --unit mm").code, 3);
  const Outcome outcome = kinetostat(
      "mesh check seams.stl --unit mm --repair weld,orient -o repaired.stl --json r.json");
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_TRUE(json("r.json")["repair"]["actions"][0]["done"].get<bool>());
  EXPECT_NEAR(json("r.json")["volume"].get<double>(), 1e-6, 1e-10);
  EXPECT_EQ(kinetostat("mesh check repaired.stl --unit mm").code, 0);
}

// What is listed can be pasted: each selector picks its face, and no other.
TEST(MeshCommand, FacesComeWithSelectorsThatPickThem) {
  write("cube.stl", cube("a", 0));
  ASSERT_EQ(kinetostat("mesh check cube.stl --unit mm --faces --json faces.json").code, 0);
  const io::Json faces = json("faces.json")["faces"];
  ASSERT_EQ(faces.size(), 6u);
  for (std::size_t i = 1; i < faces.size(); ++i) {
    EXPECT_EQ(faces[i]["kind"], "plane");
    EXPECT_NEAR(faces[i]["area"].get<double>(), 1e-4, 1e-12);
  }
  const auto direction = [&faces](std::size_t i) {
    return faces[i]["direction"].get<std::array<double, 3>>();
  };
  const auto turned = [&](std::size_t i) {
    const auto a = direction(0), b = direction(i);
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] < -0.5;
  };
  std::size_t opposite = 1;
  while (opposite + 1 < faces.size() && !turned(opposite)) ++opposite;
  const auto link = fmt::format(
      "kinetostat: 1\nlink: cube\nmesh: {{file: cube.stl, unit: mm}}\nmaterial: steel_s235\n"
      "fixed: {{{}}}\nloaded: {{{}, coupling: {{normal: 1e13 N/m^3, tangential: 1e13 N/m^3}}}}\n"
      "elements: {{size: 5}}\n",
      faces[0]["selector"].get<std::string>(), faces[opposite]["selector"].get<std::string>());
  write("cube.yaml", link);
  const Outcome found = kinetostat("identify cube.yaml -o cube.link.json");
  ASSERT_EQ(found.code, 0) << found.err;
  const io::Json result = json("cube.link.json");
  for (const char* name : {"fixed", "loaded"})
    EXPECT_NEAR(result["interfaces"][name]["area"].get<double>(), 1e-4, 1e-10);
  EXPECT_EQ(result["interfaces"]["loaded"]["coupling"], "elastic");
  EXPECT_EQ(result["material"]["name"], "steel_s235");
  EXPECT_NEAR(result["material"]["E_sd"].get<double>(), 6.3e9, 1);
  // The spread of E goes on into robots.
  write("cube_arm.yaml",
        "kinetostat: 1\nname: arm\nunits: {length: mm, force: N, angle: deg}\n"
        "links: {cube: {compliance: cube.link.json}}\nchain_types: {arm: [link: cube]}\n"
        "manipulator: {chain: arm}\n");
  const Outcome arm = kinetostat("stiffness cube_arm.yaml");
  EXPECT_EQ(arm.code, 0) << arm.err;
  EXPECT_THAT(arm.out, HasSubstr("E of cube"));
}

TEST(MeshCommand, MaterialsAreListedWithTheirSources) {
  const Outcome list = kinetostat("material list --verbose --json materials.json");
  EXPECT_EQ(list.code, 0) << list.err;
  EXPECT_THAT(list.out, HasSubstr("steel_s235"));
  EXPECT_THAT(list.out, HasSubstr("EN 1561:2011, annex A: 103 to 118 GPa"));
  EXPECT_GE(json("materials.json")["materials"].size(), 20u);
}

TEST(MeshCommand, MassPropertiesOfACubeAreThoseOfACube) {
  write("cube.stl", cube("a", 0));
  ASSERT_EQ(kinetostat("mesh check cube.stl --unit mm --density '1000 kg/m^3' --json r.json").code,
            0);
  EXPECT_NEAR(json("r.json")["mass"].get<double>(), 1e-3, 1e-9);
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(json("r.json")["center"][k].get<double>(), 0.005, 1e-9);
    EXPECT_NEAR(json("r.json")["inertia"][k][k].get<double>(), 1e-3 * 1e-4 / 6, 1e-13);
  }
}

TEST(MeshCommand, BadOptionsAreBadUsage) {
  write("cube.stl", cube("a", 0));
  for (const char* options :
       {"--repair weld,mend", "--limit -1", "--tolerance '2 N' --repair weld"}) {
    const Outcome outcome = kinetostat(std::string("mesh check cube.stl --unit mm ") + options);
    EXPECT_EQ(outcome.code, 2) << options;
  }
}

std::string link(const std::string& mesh, const std::string& fixed, const std::string& loaded,
                 const std::string& rest = "") {
  return "kinetostat: 1\nlink: part\nmesh: {" + mesh +
         "}\nmaterial: {E: 210 GPa, nu: 0.3}\nfixed: {" + fixed + "}\nloaded: {" + loaded + "}\n" +
         rest;
}

TEST(MeshCommand, OneOfSeveralBodiesIsPickedByItsName) {
  write("two.stl", cube("base", 0) + cube("cover", 30));
  EXPECT_THAT(kinetostat("mesh check two.stl --unit mm").out, HasSubstr("base (10 x 10 x 10 mm)"));
  const std::string ends =
      link("file: two.stl, unit: mm%", "plane: {point: [30, 0, 0], normal: [-1, 0, 0]}",
           "plane: {point: [40, 0, 0], normal: [1, 0, 0]}", "elements: {size: 5}\n");
  const auto with = [&ends](const std::string& more) {
    return std::string(ends).replace(ends.find('%'), 1, more);
  };
  write("two.yaml", with(""));
  const Outcome both = kinetostat("identify two.yaml");
  EXPECT_EQ(both.code, 3);
  EXPECT_THAT(both.err, HasSubstr("base (10 x 10 x 10 mm), cover (10 x 10 x 10 mm)"));
  write("two.yaml", with(", body: cower"));
  EXPECT_THAT(kinetostat("identify two.yaml").err, HasSubstr("Did you mean 'cover'?"));
  write("two.yaml", with(", body: cover"));
  EXPECT_EQ(kinetostat("identify two.yaml").code, 0);
}

// Two solids of one file that touch, each its material, with a layer between: everything about them
// is in the result, a robot reads it, and the cache gives the same again.
TEST(MeshCommand, AnAssemblySaysWhatItsBodiesAndJointsAre) {
  write("pair.stl", cube("base", 0) + cube("post", 10));
  write("pair.yaml",
        "kinetostat: 1\nlink: pair\nmesh: {file: pair.stl, unit: mm}\nmaterial: steel_s235\n"
        "bodies: {base: {}, post: {material: {E: {value: 70 GPa, sd: 10 %}, nu: 0.3}}}\n"
        "joints: [{between: [base, post], layer: {normal: 4e12 N/m^3, tangential: 1e12 N/m^3}}]\n"
        "fixed: {plane: {point: [0, 0, 0], normal: [-1, 0, 0]}}\n"
        "loaded: {plane: {point: [20, 0, 0], normal: [1, 0, 0]}}\nelements: {size: 4}\n");
  const Outcome first = kinetostat("identify pair.yaml -o pair.json --html pair.html --verbose");
  ASSERT_EQ(first.code, 0) << first.err;
  EXPECT_THAT(first.out, HasSubstr("base and post: a layer of 4e+12 N/m^3, 1e+12 N/m^3 "
                                   "tangentially, over 100 mm^2"));
  const io::Json pair = json("pair.json");
  EXPECT_FALSE(pair.contains("material"));
  ASSERT_EQ(pair["bodies"].size(), 2u);
  EXPECT_EQ(pair["bodies"][0]["name"], "base");
  EXPECT_EQ(pair["bodies"][0]["material"]["name"], "steel_s235");
  EXPECT_EQ(pair["bodies"][1]["material"]["E"], 70e9);
  EXPECT_NEAR(pair["bodies"][1]["volume"].get<double>(), 1e-6, 1e-15);
  EXPECT_EQ(pair["joints"][0]["between"][1], "post");
  EXPECT_FALSE(pair["joints"][0]["bonded"].get<bool>());
  EXPECT_EQ(pair["joints"][0]["layer"]["tangential"], 1e12);
  EXPECT_NEAR(pair["joints"][0]["area"].get<double>(), 1e-4, 1e-12);
  EXPECT_TRUE(pair["mass"].is_null());  // the post has no density
  EXPECT_NEAR(io::read_identified_link(working_folder() / "pair.json").young_deviation, 0.1, 1e-12);
  EXPECT_EQ(kinetostat("identify pair.yaml -o again.json").code, 0);
  EXPECT_THAT(kinetostat("identify pair.yaml --verbose").out, HasSubstr("from the cache"));
  EXPECT_EQ(json("again.json")["compliance"], pair["compliance"]);
  EXPECT_THAT(kinetostat("identify pair.yaml --deck pair.inp").err,
              HasSubstr("joints between bodies are not exported"));
  EXPECT_THAT(kinetostat("identify pair.yaml --no-cache --solver petsc").err,
              HasSubstr("Use another solver (--solver)"));
  EXPECT_THAT(kinetostat("beam pair.yaml").err, HasSubstr("an assembly of bodies is no beam"));
}

// The mesh and the deck that identify exports are read back as what they are.
TEST(MeshCommand, AnExportedMeshGivesTheSameComplianceAgain) {
  std::string text = io::read_text(working_folder() / "meshes/test_bar.yaml");
  text.replace(text.find("size: 3"), 7, "size: 8");
  text.replace(text.find("test_bar.stl"), 12, "meshes/test_bar.stl");
  write("bar.yaml", text);
  ASSERT_EQ(kinetostat("identify bar.yaml -o bar.json --msh bar.msh --deck bar.inp").code, 0);
  const io::Json expected = json("bar.json");
  const std::string point = "point: [0.31, 0, 0]";
  write("again.yaml", link("file: bar.msh, unit: m", "group: fixed", "group: loaded, " + point));
  write("deck.yaml",
        link("file: bar.inp, unit: m", "group: INTERFACE0", "group: INTERFACE1, " + point));
  for (const std::string name : {"again", "deck"}) {
    const Outcome outcome = kinetostat("identify " + name + ".yaml -o " + name + ".json");
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const io::Json result = json(name + ".json");
    EXPECT_EQ(result["mesh"]["elements"], expected["mesh"]["elements"]);
    EXPECT_EQ(result["mesh"]["mesher"], "from the mesh file");
    for (int i = 0; i < 6; ++i)
      for (int j = 0; j < 6; ++j) {
        const double scale = std::sqrt(expected["compliance"][i][i].get<double>() *
                                       expected["compliance"][j][j].get<double>());
        EXPECT_NEAR(result["compliance"][i][j].get<double>(),
                    expected["compliance"][i][j].get<double>(), 1e-7 * scale)
            << name << " " << i << j;
      }
  }
}

TEST(MeshCommand, AVolumeMeshIsReportedWithItsGroupsAndTakesNoRepair) {
  write("tet.inp",
        "*NODE\n1,0,0,0\n2,10,0,0\n3,0,10,0\n4,0,0,10\n*ELEMENT, TYPE=C3D4, ELSET=body\n1,1,2,3,4\n"
        "*NSET, NSET=foot\n1,2,3\n");
  const Outcome outcome = kinetostat("mesh check tet.inp --unit mm --density '6000 kg/m^3'");
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("group of faces foot: 1"));
  EXPECT_THAT(outcome.out, HasSubstr("mass 0.001 kg"));
  EXPECT_EQ(kinetostat("mesh check tet.inp --unit mm --repair weld").code, 2);
  write("tet.yaml", link("file: tet.inp, unit: mm, repair: [weld]", "group: foot", "group: foot"));
  EXPECT_THAT(kinetostat("identify tet.yaml").err, HasSubstr("'repair' is for surfaces"));
  EXPECT_THAT(kinetostat("mesh check tet.inp").err, HasSubstr("State the unit"));
}

}  // namespace
}  // namespace kinetostat::mesh_command_test
