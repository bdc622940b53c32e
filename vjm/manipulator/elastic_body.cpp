#include "kinetostat/vjm/manipulator/elastic_body.h"

#include "kinetostat/spatial/linear_algebra.h"

namespace kinetostat::vjm {

using Eigen::VectorXd;
using spatial::Matrix3;
using spatial::Pose;
using spatial::Vector3;

namespace {

// m (x - origin of the base), the first moment of the body's mass.
Vector3 first_moment(const ElasticBody& body, const Pose& axes, const VectorXd& deflections) {
  Vector3 moment = body.mass * (axes * body.center);
  moment += axes.rotation() * (body.moment * deflections);
  return moment;
}

}  // namespace

bool ElasticBody::has_weight(const Vector3& gravity) const {
  return mass > 0 && !gravity.isZero(0);
}

ElasticForces elastic_forces(const ElasticBody& body, const Pose& origin,
                             const VectorXd& deflections, const Vector3& gravity) {
  ElasticForces forces{.on_deflections = -body.stiffness * deflections};
  forces.energy = -0.5 * deflections.dot(forces.on_deflections);
  if (!body.has_weight(gravity)) return forces;
  const Pose axes = origin * body.frame;
  forces.on_deflections += body.moment.transpose() * (axes.rotation().transpose() * gravity);
  const Vector3 arm =
      first_moment(body, axes, deflections) - body.mass * origin.position();  // times the mass
  forces.on_origin << body.mass * gravity, arm.cross(gravity);
  return forces;
}

ElasticTangent elastic_tangent(const ElasticBody& body, const Pose& origin,
                               const VectorXd& deflections, const Vector3& gravity) {
  ElasticTangent tangent;
  tangent.by_turn.setZero(deflections.size(), 3);
  if (!body.has_weight(gravity)) return tangent;
  const Pose axes = origin * body.frame;
  const Matrix3 across = spatial::skew(gravity);
  tangent.by_turn = body.moment.transpose() * (axes.rotation().transpose() * across);
  const Vector3 arm = first_moment(body, axes, deflections) - body.mass * origin.position();
  tangent.moment = across * spatial::skew(arm);
  return tangent;
}

double work_of_weight(const ElasticBody& body, const Pose& origin, const VectorXd& deflections,
                      const Vector3& gravity) {
  if (!body.has_weight(gravity)) return 0;
  return gravity.dot(first_moment(body, origin * body.frame, deflections));
}

}  // namespace kinetostat::vjm
