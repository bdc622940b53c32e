#include "kinetostat/fea/interface/elastic_layer.h"

#include <cmath>
#include <tuple>

#include <gtest/gtest.h>

#include "kinetostat/fea/link/coupling_bracket.h"
#include "kinetostat/fea/link/link_response.h"

#include "fea/shapes.h"

namespace kinetostat::fea::elastic_layer_test {
namespace {

constexpr double length = 0.1, width = 0.02, height = 0.012;
constexpr double area = width * height;
constexpr double about_y = width * height * height * height / 12;
constexpr double about_z = height * width * width * width / 12;
const ElasticLayer layer{.normal = 2e12, .tangential = 5e11};
// Without lateral contraction plane ends stay plane, and the closed forms are exact.
const Material stiff(2.1e17, 0), soft(2.1e11, 0);

TetMesh bar(int order, int fineness = 1) {
  const TetMesh linear =
      box_mesh({length, width, height}, 5 * fineness, 2 * fineness, 2 * fineness);
  return order == 2 ? with_mid_nodes(linear) : linear;
}

LinkResponse response(const Material& material, Coupling fixed, Coupling loaded,
                      const SolverOptions& options = {}, int order = 2, int fineness = 1) {
  const TetMesh mesh = bar(order, fineness);
  std::vector<CoupledInterface> ends = coupled_ends(mesh, fixed, loaded);
  for (CoupledInterface& end : ends) end.layer = layer;
  common::Progress silent;
  return respond(mesh, {material}, ends, options, silent);
}

void expect_near(double found, double exact, double tolerance) {
  EXPECT_NEAR(found, exact, tolerance * exact);
}

// A stiff block on a layer: the compliance is that of the layer, per area and per second moment.
TEST(ElasticLayer, AStiffBlockOnItGivesTheExactSpring) {
  const Matrix6 held = response(stiff, Coupling::elastic, Coupling::rigid).compliance();
  expect_near(held(0, 0), 1 / (layer.normal * area), 1e-4);
  expect_near(held(3, 3), 1 / (layer.tangential * (about_y + about_z)), 1e-4);
  expect_near(held(4, 4), 1 / (layer.normal * about_y), 1e-4);
  expect_near(held(5, 5), 1 / (layer.normal * about_z), 1e-4);
  expect_near(held(1, 1),
              1 / (layer.tangential * area) + length * length / (layer.normal * about_z), 1e-4);
  for (const Coupling fixed : {Coupling::rigid, Coupling::distributing}) {
    const Matrix6 loaded = response(stiff, fixed, Coupling::elastic).compliance();
    expect_near(loaded(0, 0), 1 / (layer.normal * area), 1e-4);
    expect_near(loaded(1, 1), 1 / (layer.tangential * area), 1e-4);
    expect_near(loaded(3, 3), 1 / (layer.tangential * (about_y + about_z)), 1e-4);
    expect_near(loaded(4, 4), 1 / (layer.normal * about_y), 1e-4);
  }
}

TEST(ElasticLayer, AddsToTheBarExactly) {
  for (const auto method : {SolverMethod::direct, SolverMethod::multigrid})
    for (const auto& [fixed, loaded, layers] :
         {std::tuple{Coupling::elastic, Coupling::rigid, 1},
          std::tuple{Coupling::rigid, Coupling::elastic, 1},
          std::tuple{Coupling::elastic, Coupling::elastic, 2}}) {
      const LinkResponse found = response(soft, fixed, loaded, {.method = method});
      const Matrix6 c = found.compliance();
      expect_near(c(0, 0), (length / soft.young() + layers / layer.normal) / area, 1e-6);
      // The forces of the layer on the nodes are not those of a linear traction, element by
      // element.
      expect_near(c(4, 4), (length / soft.young() + layers / layer.normal) / about_y, 5e-4);
      expect_near(c(5, 5), (length / soft.young() + layers / layer.normal) / about_z, 5e-4);
      EXPECT_LT(spatial::symmetry_defect(c), 1e-6);
    }
}

TEST(ElasticLayer, ConvergesFastInBending) {
  const double exact = (length / soft.young() + 1 / layer.normal) / about_y;
  const auto off = [&](int fineness) {
    return response(soft, Coupling::elastic, Coupling::rigid, {}, 2, fineness).compliance()(4, 4) /
               exact -
           1;
  };
  EXPECT_LT(std::abs(off(2)), std::abs(off(1)) / 6);
}

TEST(ElasticLayer, OfFourNodeElementsHoldsForcesExactly) {
  const Matrix6 c = response(stiff, Coupling::elastic, Coupling::rigid, {}, 1).compliance();
  expect_near(c(0, 0), 1 / (layer.normal * area), 1e-5);
}

TEST(ElasticLayer, StaysWhatItIsInTheBracket) {
  const TetMesh mesh = bar(2);
  std::vector<CoupledInterface> ends = coupled_ends(mesh, Coupling::elastic, Coupling::rigid);
  for (CoupledInterface& end : ends) end.layer = layer;
  common::Progress silent;
  const LinkResponse found = respond(mesh, {soft}, ends, {}, silent);
  const CouplingBracket bracket = coupling_bracket(mesh, {soft}, ends, found, {}, silent);
  EXPECT_LT((bracket.rigid - found.flexibility).norm(), 1e-6 * found.flexibility.norm());
  EXPECT_GT(bracket.distributing(0, 0), (1 - 1e-9) * found.flexibility(0, 0));
}

}  // namespace
}  // namespace kinetostat::fea::elastic_layer_test
