#include "kinetostat/fea/mesh/curved_boundary.h"

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <stdexcept>
#include <utility>

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCore>

#include "kinetostat/common/index.h"
#include "kinetostat/fea/mesh/flat_elements.h"

namespace kinetostat::fea::curved_boundary {
namespace {

using common::at;

// Of what the element has with straight edges, or had before its nodes moved.
constexpr double least_jacobian_kept = 0.2, least_fullness_kept = 0.2;
// Of the diagonal: a nearest point farther away than any facet is that of another sheet.
constexpr double longest_way = 0.05;

// Nodes and the faces that they lie on.
using FacesOfNodes = std::map<int, std::set<int>>;

bool is_curved(const CadBoundary& cad, int face) {
  return face > 0 && cad.faces[at(face - 1)].kind != FaceKind::plane;
}

// Those that lie on a curved face, among the nodes first to last of each boundary face.
FacesOfNodes nodes_to_move(const TetMesh& mesh, const CadBoundary& cad, std::size_t first,
                           std::size_t last) {
  FacesOfNodes all;
  for (std::size_t f = 0; f < mesh.boundary.size(); ++f)
    for (std::size_t k = first; k < last; ++k)
      if (cad.face_of[f] > 0) all[mesh.boundary[f].nodes[k]].insert(cad.face_of[f]);
  std::erase_if(all, [&](const auto& entry) {
    return std::none_of(entry.second.begin(), entry.second.end(),
                        [&](int face) { return is_curved(cad, face); });
  });
  return all;
}

// Where nodes belong, those that have far to go left out.
std::map<int, Vector3> places(const TetMesh& mesh, const CadBoundary& cad,
                              const FacesOfNodes& nodes, common::Progress& progress) {
  PointsOnFaces points;
  for (const auto& [node, faces] : nodes) {
    points.points.push_back(mesh.nodes[at(node)]);
    points.faces.emplace_back(faces.begin(), faces.end());
  }
  std::map<int, Vector3> found;
  if (points.points.empty()) return found;
  const std::vector<Vector3> nearest = nearest_on_faces(cad.step, points, cad.limits, progress);
  const double most = longest_way * bounding_box(mesh.nodes).diagonal().norm();
  std::size_t i = 0;
  for (const auto& [node, faces] : nodes) {
    const Vector3& place = nearest[i++];
    if (place.allFinite() && (place - mesh.nodes[at(node)]).norm() <= most) found[node] = place;
  }
  return found;
}

// The harmonic displacement of inner nodes that continues the given one of the boundary.
class HarmonicExtension {
 public:
  explicit HarmonicExtension(const TetMesh& mesh) : number_(mesh.nodes.size(), inner) {
    for (const BoundaryFace& face : mesh.boundary)
      for (std::size_t k = 0; k < 3; ++k) number_[at(face.nodes[k])] = boundary;
    int count = 0;
    for (int& number : number_)
      if (number == inner) number = count++;
    assemble(mesh, count);
  }

  void extend(std::vector<Vector3>& displacement) const {
    if (inside_.rows() == 0) return;
    const auto nodes = static_cast<Eigen::Index>(number_.size());
    Eigen::MatrixX3d given = Eigen::MatrixX3d::Zero(nodes, 3);
    for (std::size_t n = 0; n < number_.size(); ++n)
      if (number_[n] == boundary)
        given.row(static_cast<Eigen::Index>(n)) = displacement[n].transpose();
    Eigen::ConjugateGradient<Eigen::SparseMatrix<double>, Eigen::Lower | Eigen::Upper> solver;
    solver.setTolerance(1e-6);
    solver.setMaxIterations(2000);
    solver.compute(inside_);
    const Eigen::MatrixX3d found = solver.solve(-(across_ * given).eval());
    for (std::size_t n = 0; n < number_.size(); ++n)
      if (number_[n] >= 0) displacement[n] = found.row(number_[n]).transpose();
  }

 private:
  static constexpr int inner = -1, boundary = -2;

  // Stiffness of linear elements for a potential.
  void assemble(const TetMesh& mesh, int count) {
    std::vector<Eigen::Triplet<double>> inside, across;
    for (std::size_t e = 0; e < mesh.element_count(); ++e) {
      const auto tet = mesh.element(e);
      const std::array<Vector3, 4> p = mesh.corners(e);
      const double six_volumes = 6 * volume(p);
      std::array<Vector3, 4> gradient;
      gradient[1] = (p[2] - p[0]).cross(p[3] - p[0]) / six_volumes;
      gradient[2] = (p[3] - p[0]).cross(p[1] - p[0]) / six_volumes;
      gradient[3] = (p[1] - p[0]).cross(p[2] - p[0]) / six_volumes;
      gradient[0] = -(gradient[1] + gradient[2] + gradient[3]);
      for (std::size_t i = 0; i < 4; ++i) {
        const int row = number_[at(tet[i])];
        for (std::size_t j = 0; j < 4 && row >= 0; ++j) {
          const double value = six_volumes / 6 * gradient[i].dot(gradient[j]);
          const int column = number_[at(tet[j])];
          if (column >= 0)
            inside.emplace_back(row, column, value);
          else
            across.emplace_back(row, tet[j], value);
        }
      }
    }
    inside_.resize(count, count);
    inside_.setFromTriplets(inside.begin(), inside.end());
    across_.resize(count, static_cast<Eigen::Index>(number_.size()));
    across_.setFromTriplets(across.begin(), across.end());
  }

  std::vector<int> number_;  // of inner nodes; else `boundary`
  Eigen::SparseMatrix<double> inside_, across_;
};

// The elements that lose their shape when the nodes move so.
std::vector<std::size_t> spoiled(const TetMesh& mesh, const std::vector<Vector3>& displacement) {
  std::vector<std::size_t> bad;
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    const auto tet = mesh.element(e);
    std::array<Vector3, 4> p = mesh.corners(e);
    const double before = fullness(p);
    bool moves = false;
    for (std::size_t k = 0; k < 4; ++k) {
      moves |= displacement[at(tet[k])] != Vector3::Zero();
      p[k] += displacement[at(tet[k])];
    }
    if (moves && !(volume(p) > 0 && fullness(p) >= least_fullness_kept * before)) bad.push_back(e);
  }
  return bad;
}

// Moves the corners. Where elements would be spoiled, their nodes stay, and all is tried again.
void move_corners(TetMesh& mesh, std::map<int, Vector3> targets, std::set<std::size_t>& kept) {
  const HarmonicExtension extension(mesh);
  while (!targets.empty()) {
    std::vector<Vector3> displacement(mesh.nodes.size(), Vector3::Zero());
    for (const auto& [node, place] : targets) displacement[at(node)] = place - mesh.nodes[at(node)];
    extension.extend(displacement);
    const std::vector<std::size_t> bad = spoiled(mesh, displacement);
    if (bad.empty()) {
      for (std::size_t n = 0; n < mesh.nodes.size(); ++n) mesh.nodes[n] += displacement[n];
      return;
    }
    std::size_t dropped = 0;
    for (const std::size_t e : bad)
      for (const int node : mesh.element(e)) dropped += targets.erase(node);
    kept.insert(bad.begin(), bad.end());
    if (dropped == 0) return;  // an inner element: nothing moves
  }
}

// Elements by the middles of their edges that shall move.
std::map<int, std::vector<std::size_t>> elements_of(const TetMesh& mesh,
                                                    const std::map<int, Vector3>& targets) {
  std::vector<bool> is_target(mesh.nodes.size(), false);
  for (const auto& [node, place] : targets) is_target[at(node)] = true;
  std::map<int, std::vector<std::size_t>> elements;
  for (std::size_t e = 0; e < mesh.element_count(); ++e)
    for (const int node : mesh.element(e).subspan(4))
      if (is_target[at(node)]) elements[node].push_back(e);
  return elements;
}

// Moves the middles of edges, and back to where they were those of elements that this spoils.
void move_middles(TetMesh& mesh, const std::map<int, Vector3>& targets,
                  std::set<std::size_t>& kept) {
  const auto elements = elements_of(mesh, targets);
  std::map<int, Vector3> straight;
  std::set<std::size_t> open;
  for (const auto& [node, place] : targets) {
    straight[node] = std::exchange(mesh.nodes[at(node)], place);
    const auto& around = elements.at(node);
    open.insert(around.begin(), around.end());
  }
  while (!open.empty()) {
    std::set<std::size_t> next;
    for (const std::size_t e : open) {
      if (least_jacobian(mesh, e) >= least_jacobian_kept) continue;
      for (const int node : mesh.element(e).subspan(4)) {
        const auto middle = straight.find(node);
        if (middle == straight.end() || mesh.nodes[at(node)] == middle->second) continue;
        mesh.nodes[at(node)] = middle->second;
        next.insert(elements.at(node).begin(), elements.at(node).end());
        kept.insert(e);
      }
    }
    open = std::move(next);
  }
  mesh.curved = std::any_of(targets.begin(), targets.end(), [&](const auto& entry) {
    return mesh.nodes[at(entry.first)] != straight[entry.first];
  });
}

// A point of a boundary face, with the barycentric coordinates l.
Vector3 point_of_face(const TetMesh& mesh, const BoundaryFace& face,
                      const std::array<double, 3>& l) {
  const auto p = [&](std::size_t k) -> const Vector3& { return mesh.nodes[at(face.nodes[k])]; };
  if (mesh.order == 1) return l[0] * p(0) + l[1] * p(1) + l[2] * p(2);
  Vector3 x = Vector3::Zero();
  for (std::size_t k = 0; k < 3; ++k)
    x += l[k] * (2 * l[k] - 1) * p(k) + 4 * l[k] * l[(k + 1) % 3] * p(3 + k);
  return x;
}

constexpr std::array<std::array<double, 3>, 4> samples{
    {{1.0 / 3, 1.0 / 3, 1.0 / 3}, {0.6, 0.2, 0.2}, {0.2, 0.6, 0.2}, {0.2, 0.2, 0.6}}};

std::vector<double> gaps_of(const TetMesh& mesh, const CadBoundary& cad,
                            common::Progress& progress) {
  PointsOnFaces points;
  for (std::size_t f = 0; f < mesh.boundary.size(); ++f)
    for (std::size_t s = 0; s < samples.size() && is_curved(cad, cad.face_of[f]); ++s) {
      points.points.push_back(point_of_face(mesh, mesh.boundary[f], samples[s]));
      points.faces.push_back({cad.face_of[f]});
    }
  std::vector<double> gaps(mesh.boundary.size(), 0.0);
  if (points.points.empty()) return gaps;
  const std::vector<Vector3> nearest = nearest_on_faces(cad.step, points, cad.limits, progress);
  std::size_t i = 0;
  for (std::size_t f = 0; f < mesh.boundary.size(); ++f)
    for (std::size_t s = 0; s < samples.size() && is_curved(cad, cad.face_of[f]); ++s, ++i)
      gaps[f] += (nearest[i] - points.points[i]).norm() / samples.size();
  return gaps;
}

}  // namespace
}  // namespace kinetostat::fea::curved_boundary

namespace kinetostat::fea {

TetMesh on_cad_faces(const TetMesh& linear, const CadBoundary& cad, int order,
                     common::Progress& progress) {
  using namespace curved_boundary;
  if (linear.order != 1 || cad.face_of.size() != linear.boundary.size())
    throw std::invalid_argument("on_cad_faces: order 1 and a face for each boundary face");
  TetMesh mesh = linear;
  std::set<std::size_t> kept;
  move_corners(mesh, places(mesh, cad, nodes_to_move(mesh, cad, 0, 3), progress), kept);
  if (order == 2) {
    mesh = with_mid_nodes(mesh);
    move_middles(mesh, places(mesh, cad, nodes_to_move(mesh, cad, 3, 6), progress), kept);
  }
  mesh.gaps = gaps_of(mesh, cad, progress);
  mesh.straightened = kept.size();
  return mesh;
}

}  // namespace kinetostat::fea
