#include "kinetostat/fea/mesh/tet_mesh.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <numeric>
#include <stdexcept>

#include "kinetostat/common/index.h"

namespace kinetostat::fea {
namespace {

using common::at;

// All edges once, ascending by their two corners.
std::vector<std::uint64_t> unique_edges(const TetMesh& mesh) {
  std::vector<std::uint64_t> edges;
  edges.reserve(6 * mesh.element_count());
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    const auto tet = mesh.element(e);
    for (const auto& [a, b] : tet_edges) edges.push_back(edge_key(tet[at(a)], tet[at(b)]));
  }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

// Spreads the low 21 bits of x to every third bit.
std::uint64_t spread(std::uint64_t x) {
  x &= 0x1fffff;
  x = (x | x << 32) & 0x1f00000000ffff;
  x = (x | x << 16) & 0x1f0000ff0000ff;
  x = (x | x << 8) & 0x100f00f00f00f00f;
  x = (x | x << 4) & 0x10c30c30c30c30c3;
  return (x | x << 2) & 0x1249249249249249;
}

// Place along the Z-order curve of the cube around the mesh.
std::vector<std::uint64_t> curve_places(const std::vector<Vector3>& points) {
  const Box box = bounding_box(points);
  const double width = std::max(box.sizes().maxCoeff(), std::numeric_limits<double>::min());
  std::vector<std::uint64_t> places;
  places.reserve(points.size());
  for (const Vector3& p : points) {
    const Vector3 q = (p - box.min()) / width * 2097151.0;
    places.push_back(spread(static_cast<std::uint64_t>(q.x())) |
                     spread(static_cast<std::uint64_t>(q.y())) << 1 |
                     spread(static_cast<std::uint64_t>(q.z())) << 2);
  }
  return places;
}

std::vector<int> ascending(const std::vector<std::uint64_t>& keys) {
  std::vector<int> order(keys.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&keys](int a, int b) { return keys[at(a)] < keys[at(b)]; });
  return order;
}

double least_dihedral(const std::array<Vector3, 4>& p) {
  double least = std::numbers::pi;
  for (const auto& [a, b] : tet_edges) {
    // The two corners that are not on the edge.
    const int c = a != 0 && b != 0 ? 0 : (a != 1 && b != 1 ? 1 : 2), d = 6 - a - b - c;
    const Vector3& origin = p[at(a)];
    const Vector3 edge = p[at(b)] - origin;
    const Vector3 n = edge.cross(p[at(c)] - origin);
    const Vector3 m = edge.cross(p[at(d)] - origin);
    least = std::min(least, std::atan2(n.cross(m).norm(), n.dot(m)));
  }
  return least * 180 / std::numbers::pi;
}

using MidTet = std::array<Vector3, 10>;

// Place in the element with the barycentric coordinates l.
Vector3 place(const MidTet& p, const Eigen::Vector4d& l) {
  Vector3 x = Vector3::Zero();
  for (int k = 0; k < 4; ++k) x += l[k] * (2 * l[k] - 1) * p[at(k)];
  for (std::size_t e = 0; e < tet_edges.size(); ++e)
    x += 4 * l[tet_edges[e][0]] * l[tet_edges[e][1]] * p[4 + e];
  return x;
}

// Determinant of the map from (l1, l2, l3); six times the volume for straight edges.
double jacobian(const MidTet& p, const Eigen::Vector4d& l) {
  Eigen::Matrix<double, 3, 4> by_l = Eigen::Matrix<double, 3, 4>::Zero();
  for (int k = 0; k < 4; ++k) by_l.col(k) += (4 * l[k] - 1) * p[at(k)];
  for (std::size_t e = 0; e < tet_edges.size(); ++e) {
    const auto [a, b] = tet_edges[e];
    by_l.col(a) += 4 * l[b] * p[4 + e];
    by_l.col(b) += 4 * l[a] * p[4 + e];
  }
  const Matrix3 map = by_l.rightCols<3>().colwise() - by_l.col(0);
  return map.determinant();
}

// Calls visit(l, weight) at fourteen points, exact to fifth degree; the weights add up to 1/6
// (Walkington, Quadrature on simplices of arbitrary dimension, 2000).
template <class Visit>
void integrate(Visit visit) {
  struct Corner {
    double l, weight;
  };
  for (const Corner& rule : {Corner{0.31088591926330060980, 0.018781320953002641800},
                             Corner{0.092735250310891226402, 0.012248840519393658257}})
    for (int k = 0; k < 4; ++k) {
      Eigen::Vector4d l = Eigen::Vector4d::Constant(rule.l);
      l[k] = 1 - 3 * rule.l;
      visit(l, rule.weight);
    }
  constexpr double near = 0.045503704125649649492, weight = 0.0070910034628469110730;
  for (const auto& [a, b] : tet_edges) {
    Eigen::Vector4d l = Eigen::Vector4d::Constant(near);
    l[a] = l[b] = 0.5 - near;
    visit(l, weight);
  }
}

}  // namespace

double FaceContact::area() const {
  double sum = 0;
  for (const ContactPoint& point : points) sum += point.area;
  return sum;
}

std::array<Vector3, 4> TetMesh::corners(std::size_t e) const {
  const auto tet = element(e);
  return {nodes[at(tet[0])], nodes[at(tet[1])], nodes[at(tet[2])], nodes[at(tet[3])]};
}

std::array<Vector3, 10> TetMesh::all_nodes(std::size_t e) const {
  std::array<Vector3, 10> points;
  const auto tet = element(e);
  for (std::size_t k = 0; k < 10; ++k) points[k] = nodes[at(tet[k])];
  return points;
}

std::vector<int> along_curve(const std::vector<Vector3>& points) {
  return ascending(curve_places(points));
}

TetMesh with_mid_nodes(const TetMesh& linear) {
  if (linear.order != 1) throw std::invalid_argument("with_mid_nodes: the mesh has them already");
  const std::vector<std::uint64_t> edges = unique_edges(linear);
  const int corner_count = static_cast<int>(linear.nodes.size());
  const auto middle = [&edges, corner_count](int a, int b) {
    const auto at = std::lower_bound(edges.begin(), edges.end(), edge_key(a, b));
    return corner_count + static_cast<int>(at - edges.begin());
  };
  TetMesh mesh{.order = 2, .nodes = linear.nodes};
  mesh.nodes.reserve(linear.nodes.size() + edges.size());
  for (const std::uint64_t edge : edges)
    mesh.nodes.push_back(0.5 * (linear.nodes[edge >> 32] + linear.nodes[edge & 0xffffffffu]));
  mesh.connectivity.reserve(10 * linear.element_count());
  for (std::size_t e = 0; e < linear.element_count(); ++e) {
    const auto tet = linear.element(e);
    mesh.connectivity.insert(mesh.connectivity.end(), tet.begin(), tet.end());
    for (const auto& [a, b] : tet_edges)
      mesh.connectivity.push_back(middle(tet[at(a)], tet[at(b)]));
  }
  mesh.materials = linear.materials;
  mesh.made_by = linear.made_by;
  mesh.boundary = linear.boundary;
  for (BoundaryFace& face : mesh.boundary)
    for (std::size_t k = 0; k < 3; ++k)
      face.nodes[3 + k] = middle(face.nodes[k], face.nodes[(k + 1) % 3]);
  return mesh;
}

TetMesh side_by_side(const std::vector<TetMesh>& bodies) {
  TetMesh all{.order = bodies.front().order, .made_by = bodies.front().made_by};
  const bool has_gaps =
      std::any_of(bodies.begin(), bodies.end(), [](const TetMesh& b) { return !b.gaps.empty(); });
  for (const TetMesh& body : bodies) {
    const int first = static_cast<int>(all.nodes.size());
    const int number = static_cast<int>(&body - bodies.data());
    all.nodes.insert(all.nodes.end(), body.nodes.begin(), body.nodes.end());
    for (const int node : body.connectivity) all.connectivity.push_back(first + node);
    all.materials.resize(all.element_count(), number);
    for (BoundaryFace face : body.boundary) {
      for (std::size_t k = 0; k < body.nodes_per_face(); ++k) face.nodes[k] += first;
      all.boundary.push_back(face);
    }
    all.gaps.insert(all.gaps.end(), body.gaps.begin(), body.gaps.end());
    if (has_gaps) all.gaps.resize(all.boundary.size(), 0);
    all.curved = all.curved || body.curved;
    all.straightened += body.straightened;
  }
  return all;
}

TetMesh reordered(const TetMesh& linear) {
  if (linear.order != 1) throw std::invalid_argument("reordered: order 1 is required");
  const std::vector<int> node_order = along_curve(linear.nodes);
  std::vector<int> new_number(node_order.size());
  TetMesh mesh;
  mesh.nodes.reserve(linear.nodes.size());
  for (std::size_t i = 0; i < node_order.size(); ++i) {
    new_number[at(node_order[i])] = static_cast<int>(i);
    mesh.nodes.push_back(linear.nodes[at(node_order[i])]);
  }
  std::vector<Vector3> centres;
  for (std::size_t e = 0; e < linear.element_count(); ++e) {
    const auto p = linear.corners(e);
    centres.push_back((p[0] + p[1] + p[2] + p[3]) / 4);
  }
  mesh.connectivity.reserve(linear.connectivity.size());
  for (const int e : ascending(curve_places(centres))) {
    for (const int node : linear.element(at(e))) mesh.connectivity.push_back(new_number[at(node)]);
    if (!linear.materials.empty()) mesh.materials.push_back(linear.materials[at(e)]);
  }
  mesh.boundary = linear.boundary;
  for (BoundaryFace& face : mesh.boundary)
    for (std::size_t k = 0; k < 3; ++k) face.nodes[k] = new_number[at(face.nodes[k])];
  return mesh;
}

double volume(const std::array<Vector3, 4>& p) {
  return (p[1] - p[0]).cross(p[2] - p[0]).dot(p[3] - p[0]) / 6;
}

double least_jacobian(const TetMesh& mesh, std::size_t element) {
  const MidTet p = mesh.all_nodes(element);
  double least = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 4; ++k) least = std::min(least, jacobian(p, Eigen::Vector4d::Unit(k)));
  for (const auto& [a, b] : tet_edges)
    least =
        std::min(least, jacobian(p, 0.5 * (Eigen::Vector4d::Unit(a) + Eigen::Vector4d::Unit(b))));
  return least / (6 * volume({p[0], p[1], p[2], p[3]}));
}

namespace {

template <class IsCounted>
MassProperties properties_of(const TetMesh& mesh, IsCounted is_counted) {
  MassProperties result;
  const Vector3 origin = bounding_box(mesh.nodes).center();
  Vector3 first = Vector3::Zero();
  Matrix3 second = Matrix3::Zero();
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    if (!is_counted(e)) continue;
    if (mesh.curved) {
      const MidTet p = mesh.all_nodes(e);
      integrate([&](const Eigen::Vector4d& l, double weight) {
        const double dv = weight * jacobian(p, l);
        const Vector3 r = place(p, l) - origin;
        result.volume += dv;
        first += dv * r;
        second += dv * r * r.transpose();
      });
      continue;
    }
    std::array<Vector3, 4> p = mesh.corners(e);
    const double v = volume(p);
    Vector3 sum = Vector3::Zero();
    Matrix3 squares = Matrix3::Zero();
    for (Vector3& corner : p) {
      corner -= origin;
      sum += corner;
      squares += corner * corner.transpose();
    }
    result.volume += v;
    first += v / 4 * sum;
    // Exact for a linear tetrahedron: integral of r r' = V/20 (sum of r_i r_i' + s s').
    second += v / 20 * (squares + sum * sum.transpose());
  }
  const Vector3 centre = first / result.volume;
  result.centroid = origin + centre;
  result.second_moment = second - result.volume * centre * centre.transpose();
  return result;
}

}  // namespace

MassProperties mass_properties(const TetMesh& mesh) {
  return properties_of(mesh, [](std::size_t) { return true; });
}

MassProperties mass_properties(const TetMesh& mesh, std::size_t material) {
  return properties_of(mesh, [&](std::size_t e) { return mesh.material_of(e) == material; });
}

MassProperties mass_properties(const SurfaceMesh& surface) {
  // The signed tetrahedra between the facets and a point add up to the solid.
  TetMesh fan{.nodes = surface.points};
  const int apex = static_cast<int>(fan.nodes.size());
  fan.nodes.push_back(bounding_box(surface.points).center());
  for (const Triangle& t : surface.triangles)
    fan.connectivity.insert(fan.connectivity.end(), {apex, t[0], t[1], t[2]});
  return mass_properties(fan);
}

Matrix3 inertia(const MassProperties& properties, double density) {
  const Matrix3& s = properties.second_moment;
  return density * (s.trace() * Matrix3::Identity() - s);
}

MeshQuality quality(const TetMesh& mesh) {
  MeshQuality result;
  std::vector<double> dihedrals;
  double edge_sum = 0;
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    const std::array<Vector3, 4> p = mesh.corners(e);
    dihedrals.push_back(least_dihedral(p));
    double shortest = std::numeric_limits<double>::infinity(), longest = 0;
    for (const auto& [a, b] : tet_edges) {
      const double length = (p[at(a)] - p[at(b)]).norm();
      shortest = std::min(shortest, length);
      longest = std::max(longest, length);
      edge_sum += length;
    }
    result.largest_edge_ratio = std::max(result.largest_edge_ratio, longest / shortest);
  }
  if (dihedrals.empty()) return result;
  result.mean_edge = edge_sum / (6.0 * static_cast<double>(dihedrals.size()));
  std::sort(dihedrals.begin(), dihedrals.end());
  result.least_dihedral = dihedrals.front();
  result.median_dihedral = dihedrals[dihedrals.size() / 2];
  return result;
}

int count_pieces(const TetMesh& mesh) {
  std::vector<int> parent(mesh.nodes.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&parent](int i) {
    while (parent[at(i)] != i) i = parent[at(i)] = parent[at(parent[at(i)])];
    return i;
  };
  std::vector<bool> used(mesh.nodes.size(), false);
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    const auto tet = mesh.element(e);
    for (const int node : tet) {
      used[at(node)] = true;
      parent[at(root(node))] = root(tet[0]);
    }
  }
  int pieces = 0;
  for (std::size_t i = 0; i < parent.size(); ++i)
    if (used[i] && parent[i] == static_cast<int>(i)) ++pieces;
  return pieces;
}

}  // namespace kinetostat::fea
