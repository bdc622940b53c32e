#include "kinetostat/fea/elasticity/contact_stiffness.h"

#include <cmath>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include "kinetostat/fea/link/link_response.h"
#include "kinetostat/fea/mesh/face_contact.h"

#include "fea/shapes.h"

namespace kinetostat::fea::contact_stiffness_test {
namespace {

constexpr double length = 0.125, width = 0.02, height = 0.012;
constexpr double area = width * height;
constexpr double about_y = width * height * height * height / 12;
constexpr double about_z = height * width * width * width / 12;

TetMesh moved(TetMesh mesh, const Vector3& by) {
  for (Vector3& node : mesh.nodes) node += by;
  return mesh;
}

// Two halves of a bar whose meshes do not fit; 1 and 2 are the ends, 3 is where they touch.
TetMesh halves(int order, int fineness = 1) {
  const Vector3 size(length / 2, width, height);
  TetMesh near = box_mesh(size, 3 * fineness, 2 * fineness, 3 * fineness);
  TetMesh far = box_mesh(size, 2 * fineness, 3 * fineness, 2 * fineness);
  for (BoundaryFace& face : near.boundary) face.tag = face.tag == 2 ? 3 : 1;
  for (BoundaryFace& face : far.boundary) face.tag = face.tag == 1 ? 3 : 2;
  far = moved(far, {length / 2, 0, 0});
  if (order == 2) near = with_mid_nodes(near), far = with_mid_nodes(far);
  return side_by_side({near, far});
}

TetMesh joined(int order, const ElasticLayer& layer = {}, int fineness = 1) {
  TetMesh mesh = halves(order, fineness);
  mesh.contacts = find_contacts(mesh, 0, 1, 1e-6);
  for (FaceContact& contact : mesh.contacts)
    if (layer.normal > 0) {
      contact.normal_flexibility = 1 / layer.normal;
      contact.tangential_flexibility = 1 / layer.tangential;
    }
  set_traces(mesh);
  return mesh;
}

Matrix6 compliance(const TetMesh& mesh, const std::vector<Material>& materials,
                   SolverMethod method = SolverMethod::automatic) {
  common::Progress silent;
  return respond(mesh, materials, coupled_ends(mesh), {.method = method}, silent).compliance();
}

// Forces on all nodes at these displacements.
Eigen::Matrix3Xd forces(const TetMesh& mesh, const std::vector<Material>& materials,
                        const Eigen::Matrix3Xd& displacements) {
  const DofMap all(mesh, {}, {});
  common::ThreadPool pool(1);
  common::Progress silent;
  const BlockMatrix k = assemble(mesh, materials, all, pool, silent);
  const Eigen::VectorXd values = values_of(all, displacements);
  return all.displacements(mesh, -k.residual(Eigen::VectorXd::Zero(k.size()), values));
}

bool is_inside(const Vector3& p) {
  const double off = 1e-9;
  return p.x() > off && p.x() < length - off && p.y() > off && p.y() < width - off && p.z() > off &&
         p.z() < height - off;
}

TEST(ContactStiffness, OverlapsCoverTheFaceOnce) {
  for (const int order : {1, 2}) {
    const TetMesh mesh = joined(order);
    double sum = 0;
    for (const FaceContact& contact : mesh.contacts) sum += contact.area();
    EXPECT_NEAR(sum, area, 1e-12 * area);
  }
}

// The patch test: in constant strain no node inside feels a force, at the joint neither.
TEST(ContactStiffness, ConstantStrainGoesThroughTheJoint) {
  const Material material(2.1e11, 0.3);
  Matrix3 gradient;
  gradient << 1, 2, -1, 0.5, -2, 3, 0.25, 1, 1.5;
  for (const int order : {1, 2}) {
    const TetMesh mesh = joined(order);
    Eigen::Matrix3Xd u(3, static_cast<Eigen::Index>(mesh.nodes.size()));
    for (std::size_t n = 0; n < mesh.nodes.size(); ++n)
      u.col(static_cast<Eigen::Index>(n)) = 1e-3 * gradient * mesh.nodes[n];
    const Eigen::Matrix3Xd f = forces(mesh, {material, material}, u);
    const double most = f.colwise().norm().maxCoeff();
    int inside = 0;
    for (std::size_t n = 0; n < mesh.nodes.size(); ++n) {
      if (!is_inside(mesh.nodes[n])) continue;
      EXPECT_LT(f.col(static_cast<Eigen::Index>(n)).norm(), 1e-9 * most) << n;
      inside += std::abs(mesh.nodes[n].x() - length / 2) < 1e-9 ? 1 : 0;
    }
    EXPECT_GT(inside, 2);  // on the joint
  }
}

TEST(ContactStiffness, RigidMotionsTakeNoForce) {
  const TetMesh mesh = joined(2, {.normal = 1e12, .tangential = 1e11});
  const std::vector<Material> materials{Material(2.1e11, 0.3), Material(7e10, 0.33)};
  for (const FaceContact& contact : mesh.contacts) {
    const std::vector<int> nodes = contact_nodes(mesh, contact);
    Eigen::MatrixXd rigid(3 * static_cast<Eigen::Index>(nodes.size()), 6);
    for (std::size_t n = 0; n < nodes.size(); ++n)
      rigid.middleRows<3>(3 * static_cast<Eigen::Index>(n)) =
          spatial::rigid_motion(mesh.nodes[static_cast<std::size_t>(nodes[n])]);
    const Eigen::MatrixXd k = contact_stiffness(mesh, materials, contact);
    EXPECT_LT((k * rigid).cwiseAbs().maxCoeff(), 1e-9 * k.cwiseAbs().maxCoeff());
    EXPECT_EQ(k.rows(), 60);
  }
}

// Two steels and a hundredfold contrast: the bar is the sum of its halves, however they are meshed.
TEST(ContactStiffness, HalvesOfTwoMaterialsAddUp) {
  const double e = 2.1e11;
  for (const double contrast : {1.0, 100.0, 0.01})
    for (const auto method : {SolverMethod::direct, SolverMethod::multigrid}) {
      const double f = e * contrast, half = length / 2;
      const Matrix6 c = compliance(joined(2), {Material(e, 0), Material(f, 0)}, method);
      EXPECT_NEAR(c(0, 0), (half / e + half / f) / area, 1e-6 * c(0, 0));
      EXPECT_NEAR(c(4, 4), (half / e + half / f) / about_y, 1e-6 * c(4, 4));
      EXPECT_NEAR(c(5, 5), (half / e + half / f) / about_z, 1e-6 * c(5, 5));
    }
}

// The exact spring: 1/(k A) along the bar, 1/(k I) in bending, at any stiffness of the layer.
TEST(ContactStiffness, ALayerIsTheExactSpring) {
  const double e = 2.1e11;
  for (const double stiffness : {1e9, 1e12, 1e15}) {
    const ElasticLayer layer{.normal = stiffness, .tangential = 0.3 * stiffness};
    const Matrix6 c = compliance(joined(2, layer), {Material(e, 0), Material(e, 0)});
    EXPECT_NEAR(c(0, 0), (length / e + 1 / layer.normal) / area, 1e-6 * c(0, 0));
    EXPECT_NEAR(c(4, 4), (length / e + 1 / layer.normal) / about_y, 1e-6 * c(4, 4));
    EXPECT_NEAR(c(5, 5), (length / e + 1 / layer.normal) / about_z, 1e-6 * c(5, 5));
  }
}

TEST(ContactStiffness, StiffBlocksMoveAsTheLayerLetsThem) {
  const ElasticLayer layer{.normal = 1e9, .tangential = 3e8};
  const Matrix6 c = compliance(joined(2, layer), {Material(2.1e13, 0), Material(2.1e13, 0)});
  EXPECT_NEAR(c(1, 1),
              1 / (layer.tangential * area) + length * length / 4 / (layer.normal * about_z),
              1e-4 * c(1, 1));
  EXPECT_NEAR(c(2, 2),
              1 / (layer.tangential * area) + length * length / 4 / (layer.normal * about_y),
              1e-4 * c(2, 2));
  EXPECT_NEAR(c(3, 3), 1 / (layer.tangential * (about_y + about_z)), 1e-4 * c(3, 3));
}

// Nothing has less than no energy, whatever the elements and materials are.
TEST(ContactStiffness, TheEquationsStayPositive) {
  for (const int order : {1, 2})
    for (const double nu : {0.0, 0.49})
      for (const double contrast : {1.0, 1e4}) {
        const TetMesh mesh = joined(order);
        const DofMap all(mesh, {}, {});
        common::ThreadPool pool(1);
        common::Progress silent;
        const BlockMatrix k =
            assemble(mesh, {Material(1e11, nu), Material(1e11 * contrast, 0.3)}, all, pool, silent);
        Eigen::MatrixXd dense = -k.residual(Eigen::MatrixXd::Zero(k.size(), k.size()),
                                            Eigen::MatrixXd::Identity(k.size(), k.size()));
        dense.diagonal() *= 1 + 1e-9;  // the rigid motions have none
        EXPECT_EQ(Eigen::LLT<Eigen::MatrixXd>(dense).info(), Eigen::Success);
      }
}

}  // namespace
}  // namespace kinetostat::fea::contact_stiffness_test
