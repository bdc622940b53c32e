#include "kinetostat/fea/mesh/face_contact.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>

#include <Eigen/LU>

#include "kinetostat/common/index.h"
#include "kinetostat/fea/surface/box_tree.h"
#include "kinetostat/fea/surface/surface_distance.h"

namespace kinetostat::fea::face_contact {
namespace {

using common::at;

constexpr double least_opposition = 0.866;  // cosine of 30 degrees
constexpr double least_part = 1e-13;        // of the area of a face, that an overlap has
constexpr double least_bow = 1e-5;          // of an edge that counts as curved within its face
constexpr int pieces_of_curve = 8;          // straight ones that stand for a curved edge

// A boundary face and the element behind it.
struct Side {
  int face = 0, element = 0;
  std::array<int, 3> places = {};  // of its corners in the element
  int opposite = 0;                // place of the corner that is not on the face
  std::array<Vector3, 3> corners = {};
  std::vector<Vector3> outline = {};  // the corners, and points of edges that curve within the face
  Vector3 normal = Vector3::Zero();   // unit, outward
  double area = 0;                    // [m^2] of the flat triangle
};

std::map<Triangle, int> elements_of_faces(const TetMesh& mesh, int body) {
  std::map<Triangle, int> elements;
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    if (static_cast<int>(mesh.material_of(e)) != body) continue;
    const auto tet = mesh.element(e);
    for (const auto& side : {Triangle{0, 1, 2}, {0, 1, 3}, {0, 2, 3}, {1, 2, 3}})
      elements[sorted({tet[at(side[0])], tet[at(side[1])], tet[at(side[2])]})] =
          static_cast<int>(e);
  }
  return elements;
}

// Points of the edge behind the corner k; `middle` is its mid node.
void add_curve(const Side& side, std::size_t k, const Vector3& middle,
               std::vector<Vector3>& outline) {
  const Vector3 &p = side.corners[k], &q = side.corners[(k + 1) % 3];
  const Vector3 bow = middle - 0.5 * (p + q), across = side.normal.cross(q - p);
  if (std::abs(bow.dot(across)) < least_bow * across.squaredNorm()) return;
  for (int i = 1; i < pieces_of_curve; ++i) {
    const double t = static_cast<double>(i) / pieces_of_curve;
    outline.push_back(p + t * (q - p) + 4 * t * (1 - t) * bow);
  }
}

void add_outline(const TetMesh& mesh, Side& side) {
  for (std::size_t k = 0; k < 3; ++k) {
    side.outline.push_back(side.corners[k]);
    if (mesh.curved)
      add_curve(side, k, mesh.nodes[at(mesh.boundary[at(side.face)].nodes[3 + k])], side.outline);
  }
}

Side side_of(const TetMesh& mesh, std::size_t face, int element) {
  Side side{.face = static_cast<int>(face), .element = element};
  const auto tet = mesh.element(at(element));
  side.opposite = 6;
  for (std::size_t k = 0; k < 3; ++k) {
    const int node = mesh.boundary[face].nodes[k];
    side.places[k] = static_cast<int>(std::find(tet.begin(), tet.end(), node) - tet.begin());
    side.opposite -= side.places[k];
    side.corners[k] = mesh.nodes[at(node)];
  }
  const auto& p = side.corners;
  const Vector3 area = 0.5 * (p[1] - p[0]).cross(p[2] - p[0]);
  side.area = area.norm();
  side.normal = area / side.area;
  add_outline(mesh, side);
  return side;
}

std::vector<Side> sides_of(const TetMesh& mesh, int body) {
  const std::map<Triangle, int> elements = elements_of_faces(mesh, body);
  std::vector<Side> sides;
  for (std::size_t f = 0; f < mesh.boundary.size(); ++f) {
    const auto& nodes = mesh.boundary[f].nodes;
    const auto element = elements.find(sorted({nodes[0], nodes[1], nodes[2]}));
    if (element != elements.end()) sides.push_back(side_of(mesh, f, element->second));
  }
  return sides;
}

// A polygon in the plane of a face, by barycentric coordinates of the face.
using Polygon = std::vector<Vector3>;

// What of the polygon has a coordinate k of 0 or more (Sutherland and Hodgman 1974).
Polygon cut(const Polygon& polygon, Eigen::Index k) {
  Polygon left;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector3 &here = polygon[i], &next = polygon[(i + 1) % polygon.size()];
    if (here[k] >= 0) left.push_back(here);
    if ((here[k] >= 0) != (next[k] >= 0))
      left.push_back(here + here[k] / (here[k] - next[k]) * (next - here));
  }
  return left;
}

// Barycentric coordinates of the projection of x along the normal.
Vector3 projected(const Side& side, const Vector3& x) {
  const auto& p = side.corners;
  const auto part = [&](std::size_t i, std::size_t j) {
    return 0.5 * (p[i] - x).cross(p[j] - x).dot(side.normal) / side.area;
  };
  return {part(1, 2), part(2, 0), part(0, 1)};
}

Polygon overlap(const Side& a, const Side& b) {
  Polygon polygon;
  for (auto point = b.outline.rbegin(); point != b.outline.rend(); ++point)
    polygon.push_back(projected(a, *point));
  for (Eigen::Index k = 0; k < 3; ++k) polygon = cut(polygon, k);
  return polygon;
}

// Part of the face that the triangle of these points covers; negative where it takes away from a
// polygon that is not convex.
double part_of(const Vector3& p, const Vector3& q, const Vector3& r) {
  return (q - p).x() * (r - p).y() - (q - p).y() * (r - p).x();
}

struct Weighted {
  double l, weight;  // the other two coordinates are equal
};
constexpr std::array<Weighted, 2> fourth_degree{
    {{0.108103018168070, 0.223381589678011}, {0.816847572980459, 0.109951743655322}}};

Eigen::Vector4d in_element(const Side& side, const Vector3& on_face) {
  Eigen::Vector4d l = Eigen::Vector4d::Zero();
  for (std::size_t k = 0; k < 3; ++k) l[side.places[k]] = on_face[static_cast<Eigen::Index>(k)];
  return l;
}

// Places, and their derivatives by the four barycentric coordinates, in an element.
class Placement {
 public:
  Placement(const TetMesh& mesh, int element) : curved_(mesh.curved) {
    for (std::size_t k = 0; k < 4; ++k)
      corners_.col(static_cast<Eigen::Index>(k)) = mesh.corners(at(element))[k];
    if (!curved_) return;
    const std::array<Vector3, 10> all = mesh.all_nodes(at(element));
    for (std::size_t k = 0; k < 6; ++k) middles_.col(static_cast<Eigen::Index>(k)) = all[4 + k];
  }

  Vector3 place(const Eigen::Vector4d& l) const {
    if (!curved_) return corners_ * l;
    Vector3 x = Vector3::Zero();
    for (Eigen::Index k = 0; k < 4; ++k) x += l[k] * (2 * l[k] - 1) * corners_.col(k);
    for (std::size_t e = 0; e < 6; ++e)
      x += 4 * l[tet_edges[e][0]] * l[tet_edges[e][1]] * middles_.col(static_cast<Eigen::Index>(e));
    return x;
  }
  Eigen::Matrix<double, 3, 4> slopes(const Eigen::Vector4d& l) const {
    if (!curved_) return corners_;
    Eigen::Matrix<double, 3, 4> by_l;
    for (Eigen::Index k = 0; k < 4; ++k) by_l.col(k) = (4 * l[k] - 1) * corners_.col(k);
    for (std::size_t e = 0; e < 6; ++e) {
      const auto [a, b] = tet_edges[e];
      by_l.col(a) += 4 * l[b] * middles_.col(static_cast<Eigen::Index>(e));
      by_l.col(b) += 4 * l[a] * middles_.col(static_cast<Eigen::Index>(e));
    }
    return by_l;
  }

  // The coordinates of x, which is near the element, by Newton's method; none where it fails.
  std::optional<Eigen::Vector4d> find(const Vector3& x) const {
    Eigen::Vector4d l = Eigen::Vector4d::Constant(0.25);
    constexpr int most_steps = 20;
    const double size = (corners_.col(1) - corners_.col(0)).norm();
    for (int step = 0; step < most_steps; ++step) {
      const Eigen::Matrix<double, 3, 4> by_l = slopes(l);
      const Matrix3 map = by_l.rightCols<3>().colwise() - by_l.col(0);
      const Vector3 change = map.inverse() * (x - place(l));
      l.tail<3>() += change;
      l[0] -= change.sum();
      if (!curved_ || change.norm() < 1e-13) break;
    }
    if (!((place(l) - x).norm() < 1e-9 * size)) return {};
    return l;
  }

 private:
  bool curved_;
  Eigen::Matrix<double, 3, 4> corners_;
  Eigen::Matrix<double, 3, 6> middles_;
};

// Area [m^2] of the face per part of its flat triangle, along the outward normal.
Vector3 area_vector(const Side& side, const Placement& in, const Eigen::Vector4d& l) {
  const Eigen::Matrix<double, 3, 4> by_l = in.slopes(l);
  const auto along = [&](std::size_t k) -> Vector3 {
    return by_l.col(side.places[k]) - by_l.col(side.places[0]);
  };
  return 0.5 * along(1).cross(along(2));
}

// The overlap of two faces; empty where there is none.
class Pair {
 public:
  Pair(const TetMesh& mesh, const Side& a, const Side& b, double within)
      : a_(a), b_(b), in_a_(mesh, a.element), in_b_(mesh, b.element), within_(within) {
    const auto corners = mesh.corners(at(b.element));
    height_of_b_ = 3 * volume(corners) / b.area;
  }

  std::optional<FaceContact> contact() {
    FaceContact contact{.elements = {a_.element, b_.element}, .faces = {a_.face, b_.face}};
    const Polygon polygon = overlap(a_, b_);
    for (std::size_t k = 2; k < polygon.size(); ++k)
      if (!add(polygon[0], polygon[k - 1], polygon[k], contact)) return {};
    if (contact.points.empty()) return {};
    return contact;
  }

 private:
  // False where the faces are too far from each other.
  bool add(const Vector3& p, const Vector3& q, const Vector3& r, FaceContact& contact) {
    const double part = part_of(p, q, r);
    if (std::abs(part) < least_part) return true;
    for (const Weighted& rule : fourth_degree)
      for (Eigen::Index k = 0; k < 3; ++k) {
        Vector3 l = Vector3::Constant((1 - rule.l) / 2);
        l[k] = rule.l;
        if (!add_point(l[0] * p + l[1] * q + l[2] * r, rule.weight * part, contact)) return false;
      }
    return true;
  }

  bool add_point(const Vector3& on_face, double part, FaceContact& contact) {
    ContactPoint point{.in_first = in_element(a_, on_face), .in_second = {}, .normal = {}};
    const auto in_second = in_b_.find(in_a_.place(point.in_first));
    if (!in_second) return false;
    point.in_second = *in_second;
    const double gap = std::abs(point.in_second[b_.opposite]) * height_of_b_;
    if (gap > within_) return false;
    contact.gap = std::max(contact.gap, gap);
    const Vector3 area = area_vector(a_, in_a_, point.in_first);
    point.normal = area.normalized();
    point.area = part * area.norm();
    contact.points.push_back(point);
    return true;
  }

  const Side &a_, &b_;
  Placement in_a_, in_b_;
  double within_, height_of_b_ = 0;
};

Box box_of(const Side& side, double margin) {
  Box box;
  for (const Vector3& point : side.outline) box.extend(point);
  box.min().array() -= margin;
  box.max().array() += margin;
  return box;
}

// Two curved faces of one surface have their flat triangles this far apart at most.
double bulge(const TetMesh& mesh, const std::vector<Side>& sides) {
  double most = 0;
  if (!mesh.curved) return most;
  for (const Side& side : sides)
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector3& middle = mesh.nodes[at(mesh.boundary[at(side.face)].nodes[3 + k])];
      most = std::max(most, std::abs((middle - side.corners[0]).dot(side.normal)));
    }
  return most;
}

}  // namespace
}  // namespace kinetostat::fea::face_contact

namespace kinetostat::fea {

std::vector<FaceContact> find_contacts(const TetMesh& mesh, int first, int second, double within) {
  using namespace face_contact;
  const std::vector<Side> sides = sides_of(mesh, first), others = sides_of(mesh, second);
  const double margin = within + bulge(mesh, sides) + bulge(mesh, others);
  std::vector<Box> boxes;
  boxes.reserve(others.size());
  for (const Side& side : others) boxes.push_back(box_of(side, margin));
  const BoxTree tree(std::move(boxes));
  std::vector<FaceContact> contacts;
  for (const Side& side : sides) {
    std::vector<int> near;
    tree.visit_overlapping(box_of(side, 0), [&near](int other) { near.push_back(other); });
    std::sort(near.begin(), near.end());
    for (const int n : near) {
      const Side& other = others[at(n)];
      if (side.normal.dot(other.normal) > -least_opposition) continue;
      if (auto contact = Pair(mesh, side, other, within).contact())
        contacts.push_back(*std::move(contact));
    }
  }
  return contacts;
}

void set_traces(TetMesh& mesh) {
  std::map<int, std::set<int>> faces_of;
  for (const FaceContact& contact : mesh.contacts)
    for (std::size_t s = 0; s < 2; ++s) faces_of[contact.elements[s]].insert(contact.faces[s]);
  const double of_order = mesh.order == 1 ? 1 : 8.0 / 3;
  for (FaceContact& contact : mesh.contacts)
    for (std::size_t s = 0; s < 2; ++s) {
      const auto& nodes = mesh.boundary[common::at(contact.faces[s])].nodes;
      const auto p = [&](std::size_t k) { return mesh.nodes[common::at(nodes[k])]; };
      const double area = 0.5 * (p(1) - p(0)).cross(p(2) - p(0)).norm();
      contact.trace[s] = static_cast<double>(faces_of[contact.elements[s]].size()) * of_order *
                         area / volume(mesh.corners(common::at(contact.elements[s])));
    }
}

double distance_between(const SurfaceMesh& one, const SurfaceMesh& other) {
  double least = std::numeric_limits<double>::infinity();
  const auto measure = [&least](const SurfaceMesh& from, const SurfaceMesh& to) {
    const SurfaceLocator locator(to);
    for (const Vector3& point : from.points)
      least = std::min(least, locator.nearest(point).distance);
  };
  measure(one, other);
  measure(other, one);
  return least;
}

}  // namespace kinetostat::fea
