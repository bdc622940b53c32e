#include "kinetostat/fea/mesh/delaunay.h"

#include <algorithm>

#include "kinetostat/common/index.h"

namespace kinetostat::fea {
namespace {

using common::at;

__extension__ using Wide = __int128;

constexpr std::int64_t outer = std::int64_t{1} << 28;

}  // namespace

std::int64_t turn(const GridPoint& a, const GridPoint& b, const GridPoint& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

// Differences have 30 bits, the lifted coordinates 61, the determinant 124.
bool in_circle(const GridPoint& a, const GridPoint& b, const GridPoint& c, const GridPoint& p) {
  const std::int64_t ax = a.x - p.x, ay = a.y - p.y, bx = b.x - p.x, by = b.y - p.y, cx = c.x - p.x,
                     cy = c.y - p.y;
  const Wide aa = ax * ax + ay * ay, bb = bx * bx + by * by, cc = cx * cx + cy * cy;
  return aa * (bx * cy - by * cx) + bb * (cx * ay - cy * ax) + cc * (ax * by - ay * bx) > 0;
}

bool in_diametral_circle(const GridPoint& a, const GridPoint& b, const GridPoint& p) {
  return (a.x - p.x) * (b.x - p.x) + (a.y - p.y) * (b.y - p.y) < 0;
}

Delaunay::Delaunay()
    : points_{{-outer, -outer}, {outer, -outer}, {outer, outer}, {-outer, outer}},
      face_of_{0, 0, 0, 1},
      faces_{{{0, 1, 2}, {-1, 1, -1}}, {{0, 2, 3}, {-1, -1, 0}}} {}

// Walks towards p; in a Delaunay triangulation the walk ends.
int Delaunay::locate(const GridPoint& p) const {
  int face = last_;
  for (bool moved = true; moved;) {
    moved = false;
    const Face& f = faces_[at(face)];
    for (std::size_t i = 0; i < 3 && !moved; ++i) {
      if (turn(point(f.point[(i + 1) % 3]), point(f.point[(i + 2) % 3]), p) >= 0) continue;
      face = f.across[i];
      moved = true;
    }
  }
  return face;
}

// All faces whose circle contains p hang together with the one that contains p itself.
const std::vector<int>& Delaunay::cavity(const GridPoint& p) {
  cavity_.assign(1, locate(p));
  rim_.clear();
  for (std::size_t k = 0; k < cavity_.size(); ++k) {
    const Face f = faces_[at(cavity_[k])];
    for (std::size_t i = 0; i < 3; ++i) {
      const int other = f.across[i];
      if (std::find(cavity_.begin(), cavity_.end(), other) != cavity_.end()) continue;
      if (other >= 0) {
        const Face& g = faces_[at(other)];
        if (in_circle(point(g.point[0]), point(g.point[1]), point(g.point[2]), p)) {
          cavity_.push_back(other);
          continue;
        }
      }
      rim_.push_back({f.point[(i + 1) % 3], f.point[(i + 2) % 3], other});
    }
  }
  return cavity_;
}

int Delaunay::add_face(const Face& face) {
  int number = static_cast<int>(faces_.size());
  if (unused_.empty()) {
    faces_.push_back(face);
  } else {
    number = unused_.back();
    unused_.pop_back();
    faces_[at(number)] = face;
  }
  for (const int p : face.point) face_of_[at(p)] = number;
  return number;
}

// Joins p to every side of the cavity.
void Delaunay::fill(int p, std::vector<int>& made) {
  const std::size_t first = made.size();
  for (const Rim& side : rim_) {
    const int face = add_face({{p, side.a, side.b}, {side.outer, -1, -1}});
    made.push_back(face);
    if (side.outer < 0) continue;
    Face& beyond = faces_[at(side.outer)];
    for (std::size_t i = 0; i < 3; ++i)
      if (beyond.point[(i + 1) % 3] == side.b && beyond.point[(i + 2) % 3] == side.a)
        beyond.across[i] = face;
  }
  // The side from b to p of one face is the side from p to a of the one whose a is that b.
  for (std::size_t k = first; k < made.size(); ++k)
    for (std::size_t m = first; m < made.size(); ++m)
      if (faces_[at(made[k])].point[2] == faces_[at(made[m])].point[1]) {
        faces_[at(made[k])].across[1] = made[m];
        faces_[at(made[m])].across[2] = made[k];
      }
  last_ = made.back();
}

int Delaunay::insert(const GridPoint& p, std::vector<int>& made) {
  for (const int corner : faces_[at(cavity(p).front())].point)
    if (point(corner) == p) return corner;
  for (const int f : cavity_) {
    faces_[at(f)].point[0] = -1;
    unused_.push_back(f);
  }
  const int number = point_count();
  points_.push_back(p);
  face_of_.push_back(-1);
  fill(number, made);
  return number;
}

int Delaunay::face_with_side(int a, int b) const {
  const int start = face_of_[at(a)];
  int face = start;
  do {
    const Face& f = faces_[at(face)];
    const std::size_t i = f.point[0] == a ? 0 : f.point[1] == a ? 1 : 2;
    if (f.point[(i + 1) % 3] == b) return face;
    face = f.across[(i + 1) % 3];  // the face beyond the side from the third corner to a
  } while (face >= 0 && face != start);
  return -1;
}

int Delaunay::apex(int face, int a, int b) const {
  for (const int p : faces_[at(face)].point)
    if (p != a && p != b) return p;
  return -1;
}

}  // namespace kinetostat::fea
