// The bar in its reduced model for Chrono, upright and turned: the same matrices in its own axes,
// which do not resist rigid motions of the nodes.
#include <cmath>
#include <cstdio>
#include <string>

#include "test_bar.hpp"

namespace {

int failures = 0;

void expect(bool is_right, const char* what) {
  if (is_right) return;
  std::printf("not so: %s\n", what);
  ++failures;
}

struct Modes {
  int modes;  // as many as Chrono shall find
};

// Of the nodes in their frames, the coordinates of modes at rest.
Eigen::MatrixXd rigid_motions(const link_test_bar::Link& link, Eigen::Index size) {
  Eigen::MatrixXd motions = Eigen::MatrixXd::Zero(size, 6);
  const chrono::ChFrame<>& first = link.nodes.front()->Frame();
  Eigen::Index row = 0;
  for (const auto& node : link.nodes) {
    const Eigen::Vector3d arm =
        first.GetRotMat().transpose() * (node->Frame().GetPos() - first.GetPos());
    motions.block<6, 6>(row, 0).setIdentity();
    for (Eigen::Index k = 0; k < 3; ++k)
      motions.block<3, 1>(row, 3 + k) = Eigen::Vector3d::Unit(k).cross(arm);
    row += 6;
  }
  return motions;
}

void check(const link_test_bar::Link& link) {
  const chrono::modal::ChModalAssembly& assembly = *link.assembly;
  expect(assembly.reduction == chrono::modal::ChModalAssembly::ReductionType::CRAIG_BAMPTON,
         "the modes are those of the link held at its interfaces");
  expect(!assembly.has_gravity && !assembly.updates_internal_nodes,
         "nodes that are modes have neither a weight nor a place");
  const Eigen::MatrixXd motions = rigid_motions(link, assembly.local_K.rows());
  const Eigen::MatrixXd wrenches = assembly.local_K * motions;
  expect(wrenches.norm() < 1e-6 * assembly.local_K.topRows<12>().norm(),
         "the link does not resist rigid motions");
  const double mass = 0.31 * 0.02 * 0.012 * 7850;
  const Eigen::MatrixXd rigid = motions.transpose() * assembly.local_M * motions;
  expect((rigid.topLeftCorner<3, 3>() - mass * Eigen::Matrix3d::Identity()).norm() < 1e-4 * mass,
         "rigid motions have the mass of the bar");
}

}  // namespace

int main() {
  const Modes solver{link_test_bar::modes};
  const chrono::ChFrame<> frame(
      chrono::ChVector3d(0.4, -1.2, 3.1),
      Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, -2).normalized())));
  chrono::ChSystem system;
  const auto upright = link_test_bar::add_to(system, solver);
  const auto turned = link_test_bar::add_to(system, solver, frame);
  expect(system.items.size() == 2, "both links are in the system");
  expect(std::string(link_test_bar::interfaces[1].name) == "loaded", "interfaces keep their names");
  const Eigen::Vector3d end = frame.TransformPointLocalToParent({0.31, 0, 0});
  expect((turned.nodes.at(1)->Frame().GetPos() - end).norm() < 1e-12, "nodes stand in the frame");
  for (const auto* link : {&upright, &turned}) check(*link);
  const auto &k = upright.assembly->local_K, &m = upright.assembly->local_M;
  expect((turned.assembly->local_K - k).norm() < 1e-12 * k.norm() &&
             (turned.assembly->local_M - m).norm() < 1e-12 * m.norm(),
         "a turned link is the same in its own axes");
  return failures;
}
