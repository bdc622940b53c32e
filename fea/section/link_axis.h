// The axis of a link, straight or curved, and the sections across it.
#pragma once

#include <optional>

#include "kinetostat/fea/interface/interface_selection.h"
#include "kinetostat/fea/mesh/tet_mesh.h"
#include "kinetostat/fea/section/section_outline.h"

namespace kinetostat::fea {

/// A curve as points at equal distances along it.
class Curve {
 public:
  /// `points` equal steps are laid along the polyline; its ends are kept. Requires two different
  /// points.
  Curve(const std::vector<Vector3>& polyline, int points);

  const std::vector<Vector3>& points() const { return points_; }
  double length() const { return length_; }  // [m]
  /// At the distance `arc` from the start [m], 0 to length().
  Vector3 point(double arc) const;
  /// Unit vector, averaged over two steps to either side, less near the ends. 0 < arc < length().
  Vector3 tangent(double arc) const;

 private:
  std::vector<Vector3> points_;
  double length_ = 0;
};

/// Section of the link by a plane across it.
struct Section {
  spatial::Frame frame;  // x along the axis; the pieces are in its y-z plane
  std::vector<SectionPiece> pieces;
  double area;       // of all pieces [m^2]
  Vector3 centroid;  // of all pieces [m]
};

/// A link between two interfaces, as needed to find its axis and cut it.
struct LinkBody {
  const SurfaceMesh& surface;
  const TetMesh& mesh;
  const Interface &fixed, &loaded;  // on the mesh
};

class SectionCutter {
 public:
  explicit SectionCutter(const LinkBody& body);

  /// The section at a point near the axis: the piece around the point (or nearest to it), and those
  /// beside it that are as far through the link, by the potential between the interfaces. A leg of
  /// the same link that lies across the plane but further along is left out. Empty when the plane
  /// meets nothing.
  std::optional<Section> section_at(const Vector3& point, const Vector3& tangent) const;

  /// The axis runs from where the flow of the potential enters through the fixed interface to where
  /// it leaves through the loaded one. It starts as the centres of flow in slices of equal volume
  /// between surfaces of equal potential, and is then moved onto the centroids of plane sections.
  /// Throws SectionError when the planes miss the link.
  Curve find_axis(int points) const;

 private:
  double potential_of(const SectionPiece& piece, const spatial::Frame& frame) const;
  std::vector<Vector3> slice_centres(int slices) const;

  LinkBody body_;
  double tolerance_;           // [m] for the corners of outlines
  Vector3 up_;                 // the y axis of all sections is near it
  Eigen::VectorXd potential_;  // of the nodes
};

}  // namespace kinetostat::fea
