#include "kinetostat/fea/link/link_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/common/error.h"

#include "fea/shapes.h"

namespace kinetostat::fea::link_file_test {
namespace {

using testing::HasSubstr;

constexpr const char* good =
    "kinetostat: 1\n"
    "link: foot\n"
    "mesh: {file: foot.stl, unit: mm}\n"
    "material: {E: 70 GPa, nu: 0.33, density: 2700 kg/m^3}\n"
    "fixed:  {plane: {point: [0, 0, 0], normal: [-2, 0, 0]}}\n"
    "loaded: {cylinder: {axis_point: [110, 110, 0], axis: [0, 0, 1], radius: 8}, point: [110, 110, "
    "0], coupling: rigid}\n"
    "elements: {order: 2, size: 5}\n";

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  if (at == std::string::npos) throw std::logic_error("not in the text: " + from);
  return text.replace(at, from.size(), to);
}

class LinkFile : public testing::Test {
 protected:
  void SetUp() override { folder_.file("foot.stl", "solid\nendsolid\n"); }
  LinkSpec read(const std::string& text) { return read_link(folder_.file("foot.yaml", text)); }
  std::string message(const std::string& from, const std::string& to) {
    try {
      read(replaced(good, from, to));
    } catch (const common::InputError& error) {
      return error.what();
    }
    return "";
  }
  TemporaryFolder folder_;
};

TEST_F(LinkFile, IsReadInSiUnits) {
  const LinkSpec spec = read(good);
  EXPECT_EQ(spec.name, "foot");
  EXPECT_EQ(spec.mesh_name, "foot.stl");
  EXPECT_EQ(spec.material.young(), 70e9);
  EXPECT_EQ(spec.material.density(), 2700);
  EXPECT_EQ(std::get<PlaneSelector>(spec.interfaces[0].selector).normal, Vector3(-1, 0, 0));
  const auto& bore = std::get<CylinderSelector>(spec.interfaces[1].selector);
  EXPECT_NEAR(bore.radius, 0.008, 1e-18);
  EXPECT_NEAR((bore.axis_point - Vector3(0.11, 0.11, 0)).norm(), 0, 1e-16);
  EXPECT_NEAR((*spec.interfaces[1].point - Vector3(0.11, 0.11, 0)).norm(), 0, 1e-16);
  EXPECT_EQ(spec.order, 2);
  EXPECT_NEAR(*spec.size, 0.005, 1e-18);
}

TEST_F(LinkFile, DensityPointAndElementsMayBeLeftOut) {
  std::string text = replaced(good, ", density: 2700 kg/m^3", "");
  text = replaced(text, ", point: [110, 110, 0], coupling: rigid", "");
  const LinkSpec spec = read(replaced(text, "elements: {order: 2, size: 5}\n", ""));
  EXPECT_FALSE(spec.material.density());
  EXPECT_FALSE(spec.interfaces[1].point);
  EXPECT_FALSE(spec.size);
  EXPECT_EQ(spec.order, 2);
}

TEST_F(LinkFile, EveryMistakeIsNamedWithItsLineAndKey) {
  EXPECT_THAT(message("nu: 0.33", "nu: 0.5"), HasSubstr("foot.yaml:4"));
  EXPECT_THAT(message("nu: 0.33", "nu: 0.5"), HasSubstr("material.nu"));
  EXPECT_THAT(message("70 GPa", "-70 GPa"), HasSubstr("not above zero"));
  EXPECT_THAT(message("70 GPa", "70"), HasSubstr("material.E"));
  EXPECT_THAT(message("70 GPa", "70 mm"), HasSubstr("material.E"));
  EXPECT_THAT(message("radius: 8", "radius: -8"), HasSubstr("loaded.cylinder.radius"));
  EXPECT_THAT(message("radius: 8", "raduis: 8"), HasSubstr("radius"));
  EXPECT_THAT(message("[-2, 0, 0]", "[0, 0, 0]"), HasSubstr("fixed.plane.normal"));
  EXPECT_THAT(message("unit: mm", "unit: kg"), HasSubstr("mesh.unit"));
  EXPECT_THAT(message("foot.stl", "feet.stl"), HasSubstr("feet.stl"));
  EXPECT_THAT(message("order: 2", "order: 3"), HasSubstr("elements.order"));
  EXPECT_THAT(message("coupling: rigid", "modulus_ratio: 100"), HasSubstr("coupling: body"));
  EXPECT_THAT(message("coupling: rigid", "coupling: body, modulus_ratio: 0.5"),
              HasSubstr("not between 1 and"));
  EXPECT_THAT(message("coupling: rigid", "coupling: body, modulus_ratio: 1e6"),
              HasSubstr("beyond, use 'coupling: rigid'"));
  EXPECT_THAT(message("coupling: rigid", "coupling: ridgid"), HasSubstr("rigid"));
  EXPECT_THAT(message("size: 5", "size: 5, accuracy: 1 %"), HasSubstr("Give the accuracy alone"));
  EXPECT_THAT(message("size: 5", "accuracy: 0"), HasSubstr("not between 0.001 % and 50 %"));
  EXPECT_THAT(message("size: 5", "accuracy: 200 %"), HasSubstr("elements.accuracy"));
  EXPECT_THAT(message("plane:", "shpere:"), HasSubstr("fixed"));
  EXPECT_THAT(message("radius: 8", "radius: 8}, sphere: {center: [0, 0, 0], radius: 1"),
              HasSubstr("loaded"));
}

TEST_F(LinkFile, CouplingsAreRead) {
  const LinkSpec spec =
      read(replaced(replaced(good, "coupling: rigid", "coupling: body, modulus_ratio: 200"),
                    "normal: [-2, 0, 0]}", "normal: [-2, 0, 0]}, coupling: distributing"));
  EXPECT_EQ(spec.interfaces[0].coupling, Coupling::distributing);
  EXPECT_EQ(spec.interfaces[1].coupling, Coupling::body);
  EXPECT_EQ(spec.interfaces[1].modulus_ratio, 200);
}

TEST_F(LinkFile, PreloadIsAWrenchInSiUnits) {
  const std::string text =
      std::string(good) + "preload: {force: [-500, 0, 1 kN], moment: [0, 2000, 3 N m]}\n";
  Vector6 expected;
  expected << -500, 0, 1000, 0, 2, 3;
  EXPECT_LT((*read(text).preload - expected).norm(), 1e-12);
  EXPECT_FALSE(read(good).preload);
  EXPECT_THAT(message("elements:", "preload: {moment: [1, 2, 3]}\nelements:"), HasSubstr("force"));
  EXPECT_THAT(message("coupling: rigid}", "coupling: body}\npreload: {force: [1, 0, 0]}"),
              HasSubstr("two rigid interfaces"));
}

TEST_F(LinkFile, SphereGroupAndPatchAreRead) {
  folder_.file("patch.stl", binary_stl(box_surface({0, 0, 0}, {0.1, 0.1, 0.1}), 1000));
  const std::string plane = "{plane: {point: [0, 0, 0], normal: [-2, 0, 0]}}";
  const auto selector = [&](const std::string& text) {
    return read(replaced(good, plane, text)).interfaces[0].selector;
  };
  const auto ball = std::get<SphereSelector>(selector("{sphere: {center: [1, 2, 3], radius: 4}}"));
  EXPECT_NEAR((ball.center - Vector3(0.001, 0.002, 0.003)).norm(), 0, 1e-16);
  EXPECT_NEAR(ball.radius, 0.004, 1e-16);
  EXPECT_EQ(std::get<GroupSelector>(selector("{group: base plate}")).name, "base plate");
  const auto patch = std::get<PatchSelector>(selector("{stl: patch.stl}"));
  EXPECT_EQ(patch.patch.triangles.size(), 12u);
  EXPECT_NEAR(bounding_box(patch.patch.points).max().x(), 0.1, 1e-9);
}

constexpr const char* ternary =
    "kinetostat: 1\n"
    "link: rocker\n"
    "mesh: {file: foot.stl, unit: mm}\n"
    "material: {E: 70 GPa, nu: 0.33}\n"
    "interfaces:\n"
    "  left:  {sphere: {center: [0, 0, 0], radius: 5}}\n"
    "  base:  {group: base, coupling: distributing, point: [1, 0, 0]}\n"
    "  right: {sphere: {center: [50, 0, 0], radius: 5}}\n"
    "fixed: base\n";

TEST_F(LinkFile, NamedInterfacesPutTheFixedOneFirst) {
  const LinkSpec spec = read(ternary);
  ASSERT_EQ(spec.interfaces.size(), 3u);
  EXPECT_EQ(spec.interfaces[0].name, "base");
  EXPECT_EQ(spec.interfaces[1].name, "left");
  EXPECT_EQ(spec.interfaces[2].name, "right");
  EXPECT_EQ(spec.interfaces[0].coupling, Coupling::distributing);
}

TEST_F(LinkFile, MistakesInNamedInterfacesAreNamed) {
  const auto complaint = [this](const std::string& from, const std::string& to) -> std::string {
    try {
      read(replaced(ternary, from, to));
    } catch (const common::InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(complaint("fixed: base", "fixed: bass"), HasSubstr("base"));
  EXPECT_THAT(complaint("fixed: base\n", ""), HasSubstr("fixed"));
  EXPECT_THAT(complaint("fixed: base\n", "fixed: base\nloaded: left\n"), HasSubstr("loaded"));
  EXPECT_THAT(complaint("  left:  {sphere: {center: [0, 0, 0], radius: 5}}\n", "  left: {}\n"),
              HasSubstr("interfaces.left"));
}

TEST_F(LinkFile, AMaterialMayBeNamed) {
  const std::string values = "{E: 70 GPa, nu: 0.33, density: 2700 kg/m^3}";
  const LinkSpec spec = read(replaced(good, values, "aluminium_6082"));
  EXPECT_EQ(spec.material_name, "aluminium_6082");
  EXPECT_EQ(spec.material.young(), 70e9);
  EXPECT_EQ(spec.material.poisson(), 0.3);
  EXPECT_EQ(spec.material.density(), 2700);
  EXPECT_NEAR(spec.young_deviation, 0.02 * 70e9, 1);
  EXPECT_THAT(message(values, "aluminum_6082"),
              HasSubstr("foot.yaml:4: material: 'aluminum_6082' is not one of"));
  EXPECT_THAT(message(values, "aluminum_6082"), HasSubstr("Did you mean 'aluminium_6082'?"));
}

TEST_F(LinkFile, YoungsModulusMayBeUncertain) {
  const LinkSpec spec = read(replaced(good, "E: 70 GPa", "E: {value: 70 GPa, sd: 4 %}"));
  EXPECT_EQ(spec.material.young(), 70e9);
  EXPECT_NEAR(spec.young_deviation, 2.8e9, 1);
  EXPECT_NEAR(read(replaced(good, "E: 70 GPa", "E: {value: 70 GPa, sd: 2 GPa}")).young_deviation,
              2e9, 1);
  EXPECT_THAT(message("E: 70 GPa", "E: {value: 70 GPa, sd: 200 %}"),
              HasSubstr("foot.yaml:4: material.E.sd: '200 %' is not between zero and the value"));
  EXPECT_THAT(message("E: 70 GPa", "E: {value: 70 GPa}"), HasSubstr("sd"));
}

TEST_F(LinkFile, ACouplingMayBeAnElasticLayer) {
  const LinkSpec spec = read(replaced(
      good, "coupling: rigid", "coupling: {normal: 1.5 N/(um mm^2), tangential: 4e11 N/m^3}"));
  EXPECT_EQ(spec.interfaces[1].coupling, Coupling::elastic);
  EXPECT_NEAR(spec.interfaces[1].layer.normal, 1.5e12, 1);
  EXPECT_NEAR(spec.interfaces[1].layer.tangential, 4e11, 1);
  EXPECT_THAT(message("coupling: rigid", "coupling: {normal: 1e12 N/m^3}"),
              HasSubstr("tangential"));
  EXPECT_THAT(message("coupling: rigid", "coupling: {normal: 1e12 N/m, tangential: 1e12 N/m^3}"),
              HasSubstr("foot.yaml:6: loaded.coupling.normal"));
  EXPECT_THAT(message("coupling: rigid", "coupling: {normal: -1 N/m^3, tangential: 1e12 N/m^3}"),
              HasSubstr("'-1 N/m^3' is not above zero"));
}

}  // namespace
}  // namespace kinetostat::fea::link_file_test
