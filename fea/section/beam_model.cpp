#include "kinetostat/fea/section/beam_model.h"

#include <cmath>

#include <Eigen/LU>

namespace kinetostat::fea {

Matrix6 compliance_per_length(const SectionProperties& section, const Material& material) {
  const double e = material.young(), g = material.mu();
  const Vector2 centre = section.shear_centre - section.centroid;
  // Moments about y and z bend with stresses E (z ky - y kz).
  Matrix2 bending;
  bending << section.second_moment(1, 1), -section.second_moment(0, 1),  //
      -section.second_moment(0, 1), section.second_moment(0, 0);
  Matrix6 own = Matrix6::Zero();  // shear and torsion taken at the shear centre
  own(0, 0) = 1 / (e * section.area);
  own.block<2, 2>(1, 1) = section.shear_compliance / g;
  own(3, 3) = 1 / (g * section.torsion_constant);
  own.block<2, 2>(4, 4) = (e * bending).inverse();
  Matrix6 at_centre = Matrix6::Identity();
  at_centre(3, 1) = centre.y();
  at_centre(3, 2) = -centre.x();
  return at_centre.transpose() * own * at_centre;
}

spatial::Compliance6 chain_compliance(const std::vector<BeamElement>& beams,
                                      const Material& material, const Vector3& point) {
  const spatial::Frame end{.point = point, .axes = Matrix3::Identity()};
  Matrix6 sum = Matrix6::Zero();
  for (const BeamElement& beam : beams) {
    const Matrix6 local = compliance_per_length(beam.section, material);
    // The energy is quadratic in the distance along the beam: two points integrate it exactly.
    for (const double side : {-1.0, 1.0}) {
      spatial::Frame station = beam.middle;
      station.point += station.axes * Vector3(side * beam.length / std::sqrt(12.0),
                                              beam.section.centroid.x(), beam.section.centroid.y());
      const Matrix6 carried = spatial::wrench_transform(end, station);
      sum += beam.length / 2 * carried.transpose() * local * carried;
    }
  }
  return spatial::Compliance6(0.5 * (sum + sum.transpose()), end);
}

}  // namespace kinetostat::fea
