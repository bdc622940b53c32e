#include "kinetostat/fea/interface/reduced_stiffness.h"

#include "kinetostat/spatial/free_stiffness.h"

namespace kinetostat::fea {

Eigen::MatrixXd reduced_stiffness(const Eigen::MatrixXd& flexibility,
                                  const std::vector<CoupledInterface>& interfaces) {
  std::vector<Vector3> points;
  points.reserve(interfaces.size());
  for (const CoupledInterface& interface : interfaces) points.push_back(interface.point);
  return spatial::free_stiffness(flexibility, points, 0);
}

}  // namespace kinetostat::fea
