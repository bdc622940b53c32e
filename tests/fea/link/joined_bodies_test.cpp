// Links of several bodies: their files, their joints, and what they come to.
#include <cmath>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/common/error.h"
#include "kinetostat/fea/link/identify.h"
#include "kinetostat/fea/link/modal_study.h"

#include "fea/shapes.h"

namespace kinetostat::fea::joined_bodies_test {
namespace {

using testing::HasSubstr;

// A cantilever of two layers in z, 120 x 12 x (6 + 4) mm.
constexpr double length = 0.12, width = 0.012, lower = 0.006, upper = 0.004;
constexpr double steel = 210e9, aluminium = 70e9;
const Vector3 top_low(0, 0, lower), top_high(length, width, lower + upper);

const std::string bonded = "joints: [{between: [a, b], bonded: true}]\n";

class JoinedBodies : public testing::Test {
 protected:
  void SetUp() override {
    write("lower.stl", box_surface(Vector3::Zero(), {length, width, lower}));
    write("upper.stl", box_surface(top_low, top_high));
    write("whole.stl", box_surface(Vector3::Zero(), top_high));
    write("near.stl", box_surface(Vector3::Zero(), {length / 2, width, lower}));
    write("far.stl", box_surface({length / 2, 0, 0}, {length, width, lower}));
  }
  void write(const std::string& name, const SurfaceMesh& surface) {
    folder_.file(name, binary_stl(surface, 1e3));
  }

  static std::string bodies(const std::string& first, const std::string& second,
                            const std::string& of_first, const std::string& of_second) {
    return fmt::format(
        "bodies:\n  a: {{mesh: {{file: {}, unit: mm}}, material: {{{}}}}}\n"
        "  b: {{mesh: {{file: {}, unit: mm}}, material: {{{}}}}}\n",
        first, of_first, second, of_second);
  }
  // One bar of this material, and the same in two bonded halves.
  static std::string whole(const std::string& material) {
    return "mesh: {file: whole.stl, unit: mm}\nmaterial: {" + material + "}\n";
  }
  static std::string cut_in_two(const std::string& material) {
    return bodies("lower.stl", "upper.stl", material, material) + bonded;
  }
  static std::string ends(const std::string& coupling) {
    return fmt::format(
        "fixed: {{plane: {{point: [0, 0, 0], normal: [-1, 0, 0]}}, coupling: {0}}}\n"
        "loaded: {{plane: {{point: [120, 0, 0], normal: [1, 0, 0]}}, coupling: {0}}}\n",
        coupling);
  }
  LinkSpec spec(const std::string& text) {
    return read_link(folder_.file("link.yaml", "kinetostat: 1\nlink: pair\n" + text));
  }
  LinkResult identified(const std::string& text) {
    const LinkSpec link = spec(text);
    common::Progress silent;
    return identify(link, read_geometry(link, silent), {.bracket = BracketWanted::never}, silent);
  }
  std::string message(const std::string& text) {
    try {
      const LinkSpec link = spec(text);
      common::Progress silent;
      const LinkGeometry geometry = read_geometry(link, silent);
      LinkMesher mesher(geometry);
      fill(link, geometry, mesher, {.edge_length = 0.004}, silent);
    } catch (const common::InputError& error) {
      return error.what();
    }
    return "";
  }

  test::TemporaryFolder folder_;
};

const std::string of_steel = "E: 210 GPa, nu: 0, density: 7850 kg/m^3";
const std::string of_aluminium = "E: 70 GPa, nu: 0, density: 2700 kg/m^3";

// The transformed section: stiffness EA about the common neutral axis, EI about that. Without
// lateral contraction plane sections stay plane, and the rigid ends change nothing.
TEST_F(JoinedBodies, ATwoLayerCantileverIsTheTransformedSection) {
  const LinkResult link = identified(bodies("lower.stl", "upper.stl", of_steel, of_aluminium) +
                                     bonded + ends("rigid") + "elements: {accuracy: 0.1 %}\n");
  EXPECT_TRUE(link.accuracy.converged) << link.accuracy.shortfall;
  const double stretch = width * (steel * lower + aluminium * upper);
  const double neutral =
      width * (steel * lower * lower / 2 + aluminium * upper * (lower + upper / 2)) / stretch;
  const auto bent = [&](double young, double thickness, double middle) {
    return young * width *
           (std::pow(thickness, 3) / 12 + thickness * std::pow(middle - neutral, 2));
  };
  const double bending = bent(steel, lower, lower / 2) + bent(aluminium, upper, lower + upper / 2);
  const double sideways = std::pow(width, 2) / 12 * stretch;
  const double above = link.interfaces[1].point.z() - neutral;  // of the point of the compliance
  const Matrix6 c = link.compliance.matrix();
  EXPECT_NEAR(c(4, 4), length / bending, 1e-3 * length / bending);
  EXPECT_NEAR(c(5, 5), length / sideways, 1e-3 * length / sideways);
  const double axial = length / stretch + above * above * length / bending;
  EXPECT_NEAR(c(0, 0), axial, 1e-3 * axial);
  EXPECT_NEAR(c(0, 4), above * length / bending, 1e-3 * std::abs(above) * length / bending);
  EXPECT_NEAR(c(2, 4), -length * length / 2 / bending, 1e-3 * length * length / 2 / bending);
  EXPECT_NEAR(*link.mass, width * length * (7850 * lower + 2700 * upper), 1e-9);
  ASSERT_EQ(link.joints.size(), 1u);
  EXPECT_NEAR(link.joints[0].area, length * width, 1e-9 * length * width);
  EXPECT_LT(link.joints[0].gap, 1e-8);
}

// A layer across the bar is a spring in series: 1/(k A) along it, 1/(k I) in bending.
TEST_F(JoinedBodies, ALayerBetweenHalvesIsASpringInSeries) {
  const double k = 3e12, kt = 1e12, area = width * lower;
  const double about_y = width * std::pow(lower, 3) / 12, about_z = lower * std::pow(width, 3) / 12;
  const LinkResult link = identified(
      bodies("near.stl", "far.stl", of_steel, of_steel) +
      "joints: [{between: [b, a], layer: {normal: 3e12 N/m^3, tangential: 1e12 N/m^3}}]\n" +
      ends("rigid") + "elements: {accuracy: 0.1 %}\n");
  EXPECT_TRUE(link.accuracy.converged) << link.accuracy.shortfall;
  const Matrix6 c = link.compliance.matrix();
  EXPECT_NEAR(c(0, 0), (length / steel + 1 / k) / area, 1e-3 * c(0, 0));
  EXPECT_NEAR(c(4, 4), (length / steel + 1 / k) / about_y, 1e-3 * c(4, 4));
  EXPECT_NEAR(c(5, 5), (length / steel + 1 / k) / about_z, 1e-3 * c(5, 5));
  EXPECT_GT(c(1, 1), 1 / (kt * area));
}

TEST_F(JoinedBodies, OneBodyCutInTwoIsTheSameLink) {
  const std::string material = "E: 70 GPa, nu: 0.33, density: 2700 kg/m^3";
  const std::string rest = ends("rigid") + "elements: {accuracy: 0.5 %}\n";
  const LinkResult two = identified(cut_in_two(material) + rest);
  const LinkResult one = identified(whole(material) + rest);
  EXPECT_TRUE(two.accuracy.converged) << two.accuracy.shortfall;
  const Eigen::MatrixXd off = (two.response.flexibility - one.response.flexibility).cwiseAbs() -
                              two.accuracy.bars.bar - one.accuracy.bars.bar;
  EXPECT_LT(off.maxCoeff(), 0);
  EXPECT_NEAR(*two.mass, *one.mass, 1e-9 * *one.mass);
  EXPECT_LT((two.center_of_mass - one.center_of_mass).norm(), 1e-9);
  EXPECT_LT((*two.inertia - *one.inertia).norm(), 1e-9 * one.inertia->norm());
}

TEST_F(JoinedBodies, AndHasTheSameModes) {
  const std::string material = "E: 70 GPa, nu: 0.33, density: 2700 kg/m^3";
  common::Progress silent;
  const auto modes = [&](const std::string& of) {
    const LinkSpec link = spec(of + ends("rigid") + "elements: {size: 4}\n");
    return modal_study(link, read_geometry(link, silent), {.modes = 3}, silent);
  };
  const ModalResult two = modes(cut_in_two(material));
  const ModalResult one = modes(whole(material));
  for (std::size_t k = 0; k < 3; ++k)
    EXPECT_NEAR(two.modes[k].frequency, one.modes[k].frequency,
                (two.modes[k].error + one.modes[k].error) * one.modes[k].frequency);
}

TEST_F(JoinedBodies, AndBucklesUnderTheSameForce) {
  const std::string material = "E: 70 GPa, nu: 0.33";
  const std::string rest = ends("rigid") + "elements: {size: 4}\npreload: {force: [-1000, 0, 0]}\n";
  const LinkResult two = identified(cut_in_two(material) + rest);
  const LinkResult one = identified(whole(material) + rest);
  EXPECT_NEAR(two.geometric_stiffness->buckling_free, one.geometric_stiffness->buckling_free,
              5e-3 * one.geometric_stiffness->buckling_free);
  EXPECT_NEAR(two.geometric_stiffness->buckling_held, one.geometric_stiffness->buckling_held,
              5e-3 * one.geometric_stiffness->buckling_held);
}

// Elements of a bar in two sets, for CalculiX; lengths in mm.
std::string deck_of(const TetMesh& mesh) {
  std::string text = "*NODE\n";
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n)
    text += fmt::format("{}, {}, {}, {}\n", n + 1, 1e3 * mesh.nodes[n].x(), 1e3 * mesh.nodes[n].y(),
                        1e3 * mesh.nodes[n].z());
  for (const bool far : {false, true}) {
    text += fmt::format("*ELEMENT, TYPE=C3D4, ELSET={}\n", far ? "far" : "near");
    for (std::size_t e = 0; e < mesh.element_count(); ++e) {
      double middle = 0;
      for (const Vector3& corner : mesh.corners(e)) middle += corner.x() / 4;
      const auto tet = mesh.element(e);
      if (far == (middle > length / 2))
        text += fmt::format("{}, {}, {}, {}, {}\n", e + 1, tet[0] + 1, tet[1] + 1, tet[2] + 1,
                            tet[3] + 1);
    }
  }
  return text;
}

TEST_F(JoinedBodies, GroupsOfAVolumeMeshAreBodies) {
  folder_.file("bar.inp", deck_of(box_mesh({length, width, lower}, 8, 2, 1)));
  const LinkResult link = identified(
      "mesh: {file: bar.inp, unit: mm}\nmaterial: {E: 210 GPa, nu: 0}\n"
      "bodies: {near: {}, far: {material: {E: 70 GPa, nu: 0}}}\n"
      "joints: [{between: [near, far], bonded: true}]\n" +
      ends("rigid"));
  const double exact = length / 2 * (1 / steel + 1 / aluminium) / (width * lower);
  EXPECT_NEAR(link.compliance.matrix()(0, 0), exact, 1e-6 * exact);
  EXPECT_EQ(link.bodies[0].elements, link.bodies[1].elements);
}

TEST_F(JoinedBodies, SameBytesForAnyNumberOfThreads) {
  const LinkSpec link = spec(bodies("lower.stl", "upper.stl", of_steel, of_aluminium) + bonded +
                             ends("rigid") + "elements: {size: 4}\n");
  common::Progress silent;
  const LinkGeometry geometry = read_geometry(link, silent);
  IdentifyOptions options{.bracket = BracketWanted::always};
  const LinkResult one = identify(link, geometry, options, silent);
  options.solver.threads = 3;
  const LinkResult three = identify(link, geometry, options, silent);
  EXPECT_EQ(one.response.flexibility, three.response.flexibility);
  EXPECT_EQ(one.accuracy.bars.bar, three.accuracy.bars.bar);
  ASSERT_TRUE(one.bracket);
  EXPECT_LE(one.bracket->rigid(4, 4), one.bracket->distributing(4, 4));
}

TEST_F(JoinedBodies, AnInterfaceMayBeOnOneBodyAlone) {
  const auto held = [&](const std::string& body) {
    const LinkSpec link =
        spec(bodies("lower.stl", "upper.stl", of_steel, of_steel) + bonded +
             "fixed: {plane: {point: [0, 0, 0], normal: [-1, 0, 0]}" + body +
             "}\nloaded: {nearest_face: {point: [200, 6, 8], direction: [-1, 0, 0]}}\n");
    common::Progress silent;
    const LinkGeometry geometry = read_geometry(link, silent);
    LinkMesher mesher(geometry);
    const TetMesh mesh = fill(link, geometry, mesher, {.edge_length = 0.006}, silent);
    const std::vector<CoupledInterface> interfaces = interfaces_on(link, mesh);
    EXPECT_NEAR(interfaces[1].geometry.area, width * upper, 1e-9);  // what the ray meets first
    return interfaces[0].geometry.area;
  };
  EXPECT_NEAR(held(""), width * (lower + upper), 1e-9);
  EXPECT_NEAR(held(", body: a"), width * lower, 1e-9);
  EXPECT_NEAR(held(", body: b"), width * upper, 1e-9);
}

TEST_F(JoinedBodies, MistakesAreNamedWithTheirPlaceAndCure) {
  const std::string pair = bodies("lower.stl", "upper.stl", of_steel, of_aluminium);
  EXPECT_EQ(message(pair + bonded + ends("rigid")), "");
  EXPECT_THAT(message(pair + ends("distributing")),
              HasSubstr("link.yaml:5: bodies.b.mesh: nothing holds the body b: no joint leads to "
                        "it from a. Add to 'joints', for example '- {between: [a, b], bonded: "
                        "true}'"));
  EXPECT_EQ(message(pair + ends("rigid")), "");  // both are between rigid ends
  const std::string on_joint =
      "fixed: {plane: {point: [0, 0, 6], normal: [0, 0, 1]}}\n"
      "loaded: {plane: {point: [0, 0, 10], normal: [0, 0, 1]}}\n";
  EXPECT_THAT(
      message(pair + bonded + on_joint),
      HasSubstr("fixed.plane: the fixed interface lies on the joint of a and b. Choose faces "
                "that no other body touches"));
  EXPECT_THAT(message(pair + "joints: [{between: [a, c], bonded: true}]\n" + ends("rigid")),
              HasSubstr("joints[0].between"));
  EXPECT_THAT(message(pair + "joints: [{between: [a, a], bonded: true}]\n" + ends("rigid")),
              HasSubstr("a body has no joint with itself"));
  EXPECT_THAT(message(pair + "joints: [{between: [a, b], bonded: false}]\n" + ends("rigid")),
              HasSubstr("Write 'bonded: true', or leave the joint out where they slide"));
  EXPECT_THAT(message(pair +
                      "joints: [{between: [a, b], bonded: true}, {between: [b, a], bonded: "
                      "true}]\n" +
                      ends("rigid")),
              HasSubstr("these bodies have a joint already"));
  EXPECT_THAT(message(pair +
                      "joints: [{between: [a, b], layer: {normal: 0 N/m^3, tangential: 1 "
                      "N/m^3}}]\n" +
                      ends("rigid")),
              HasSubstr("joints[0].layer.normal"));
  EXPECT_THAT(message("mesh: {file: whole.stl, unit: mm}\nmaterial: {E: 1 GPa, nu: 0}\n" + bonded +
                      ends("rigid")),
              HasSubstr("joints are between bodies, and there are none"));
  EXPECT_THAT(message("bodies: {a: {mesh: {file: whole.stl, unit: mm}, material: steel_s235}}\n" +
                      ends("rigid")),
              HasSubstr("an assembly has two bodies at least"));
}

TEST_F(JoinedBodies, BodiesThatDoNotTouchAreRefusedWithTheirDistance) {
  write("lifted.stl", box_surface(top_low + Vector3(0, 0, 5e-4), top_high + Vector3(0, 0, 5e-4)));
  const std::string pair = bodies("lower.stl", "lifted.stl", of_steel, of_steel);
  EXPECT_THAT(
      message(pair + bonded + ends("rigid")),
      HasSubstr("joints[0]: the faces of a and b do not touch: within 0.121 mm, none lie on "
                "each other. They are 0.5 mm apart: bring them together, or give 'within: "
                "0.505 mm'"));
  EXPECT_EQ(
      message(pair + "joints: [{between: [a, b], bonded: true, within: 0.505}]\n" + ends("rigid")),
      "");
}

}  // namespace
}  // namespace kinetostat::fea::joined_bodies_test
