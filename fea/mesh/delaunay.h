// Delaunay triangulation of points on an integer grid, one point after the other.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace kinetostat::fea {

/// Coordinates within +-2^27. Every decision about such points is exact in 128-bit integers.
struct GridPoint {
  std::int64_t x = 0, y = 0;

  bool operator==(const GridPoint& other) const = default;
};

/// Positive when a, b, c turn counterclockwise: twice the area.
std::int64_t turn(const GridPoint& a, const GridPoint& b, const GridPoint& c);
/// True when p lies inside the circle through a, b, c (counterclockwise), not on it.
bool in_circle(const GridPoint& a, const GridPoint& b, const GridPoint& c, const GridPoint& p);
/// True when p lies inside the circle with diameter ab, not on it.
bool in_diametral_circle(const GridPoint& a, const GridPoint& b, const GridPoint& p);

class Delaunay {
 public:
  /// A face has three points, counterclockwise, and the faces across the sides opposite to them.
  struct Face {
    std::array<int, 3> point;
    std::array<int, 3> across;  // -1 beyond the outer square
  };
  /// The first points are the corners of a square far outside.
  static constexpr int outer_points = 4;

  Delaunay();

  /// Number of the point, an earlier one when it is there already. Appends the new faces to
  /// `made` (Bowyer 1981, Watson 1981).
  int insert(const GridPoint& p, std::vector<int>& made);

  /// The faces that insert(p) would replace.
  const std::vector<int>& cavity(const GridPoint& p);

  /// A face that has the side from a to b, or -1. The side from b to a is in the face across.
  int face_with_side(int a, int b) const;

  const GridPoint& point(int p) const { return points_[static_cast<std::size_t>(p)]; }
  int point_count() const { return static_cast<int>(points_.size()); }
  /// Faces that were replaced have point[0] = -1.
  const std::vector<Face>& faces() const { return faces_; }
  bool alive(int face) const { return faces_[static_cast<std::size_t>(face)].point[0] >= 0; }
  /// The corner of `face` opposite to its side from a to b.
  int apex(int face, int a, int b) const;

 private:
  struct Rim {  // a side of the cavity, seen from inside
    int a, b, outer;
  };

  int locate(const GridPoint& p) const;
  int add_face(const Face& face);
  void fill(int p, std::vector<int>& made);

  std::vector<GridPoint> points_;
  std::vector<int> face_of_;  // one of the faces of each point
  std::vector<Face> faces_;
  std::vector<int> unused_;
  std::vector<int> cavity_;
  std::vector<Rim> rim_;
  int last_ = 0;
};

}  // namespace kinetostat::fea
