#include "kinetostat/fea/section/section.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <Eigen/Eigenvalues>
#include <Eigen/SparseCholesky>

#include "kinetostat/common/index.h"

namespace kinetostat::fea {
namespace {

using common::at;
using Gradients = Eigen::Matrix<double, 6, 2>;
using Vector6Nodes = Eigen::Matrix<double, 6, 1>;

// Triangles with nodes on the middles of sides 01, 12, 20 as nodes 3, 4, 5.
struct QuadraticMesh {
  std::vector<Vector2> points;
  std::vector<std::array<int, 6>> triangles;
};

QuadraticMesh quadratic(const SectionMesh& linear) {
  QuadraticMesh mesh{linear.points, {}};
  std::map<std::pair<int, int>, int> middle;
  for (const Triangle& t : linear.triangles) {
    std::array<int, 6> nodes{t[0], t[1], t[2], 0, 0, 0};
    for (std::size_t k = 0; k < 3; ++k) {
      const int a = t[k], b = t[(k + 1) % 3];
      const auto [place, is_new] =
          middle.try_emplace(std::minmax(a, b), static_cast<int>(mesh.points.size()));
      if (is_new) mesh.points.emplace_back((linear.points[at(a)] + linear.points[at(b)]) / 2);
      nodes[3 + k] = place->second;
    }
    mesh.triangles.push_back(nodes);
  }
  return mesh;
}

// A point of the rule that integrates polynomials of degree 4 over a triangle (Dunavant 1985).
struct RulePoint {
  double l0, l1, l2, weight;
};

constexpr double a1 = 0.445948490915965, w1 = 0.223381589678011, a2 = 0.091576213509771,
                 w2 = 0.109951743655322;
constexpr std::array<RulePoint, 6> rule{{{1 - 2 * a1, a1, a1, w1},
                                         {a1, 1 - 2 * a1, a1, w1},
                                         {a1, a1, 1 - 2 * a1, w1},
                                         {1 - 2 * a2, a2, a2, w2},
                                         {a2, 1 - 2 * a2, a2, w2},
                                         {a2, a2, 1 - 2 * a2, w2}}};

Vector6Nodes shape(const RulePoint& p) {
  Vector6Nodes n;
  n << p.l0 * (2 * p.l0 - 1), p.l1 * (2 * p.l1 - 1), p.l2 * (2 * p.l2 - 1), 4 * p.l0 * p.l1,
      4 * p.l1 * p.l2, 4 * p.l2 * p.l0;
  return n;
}

// One triangle with straight sides.
struct Element {
  std::array<int, 6> nodes;
  std::array<Vector2, 3> corners;
  double area;
  Eigen::Matrix<double, 3, 2> slopes;  // of the area coordinates

  Vector2 point(const RulePoint& p) const {
    return p.l0 * corners[0] + p.l1 * corners[1] + p.l2 * corners[2];
  }
  Gradients gradients(const RulePoint& p) const {
    Gradients g;
    g << (4 * p.l0 - 1) * slopes.row(0), (4 * p.l1 - 1) * slopes.row(1),
        (4 * p.l2 - 1) * slopes.row(2), 4 * (p.l1 * slopes.row(0) + p.l0 * slopes.row(1)),
        4 * (p.l2 * slopes.row(1) + p.l1 * slopes.row(2)),
        4 * (p.l0 * slopes.row(2) + p.l2 * slopes.row(0));
    return g;
  }
  Vector6Nodes values(const Eigen::VectorXd& field) const {
    Vector6Nodes v;
    for (Eigen::Index i = 0; i < 6; ++i) v[i] = field[nodes[at(i)]];
    return v;
  }
};

Element element(const QuadraticMesh& mesh, std::size_t t, const Vector2& origin) {
  Element e{.nodes = mesh.triangles[t], .corners = {}, .area = 0, .slopes = {}};
  for (std::size_t k = 0; k < 3; ++k) e.corners[k] = mesh.points[at(e.nodes[k])] - origin;
  const Vector2 u = e.corners[1] - e.corners[0], v = e.corners[2] - e.corners[0];
  e.area = (u.x() * v.y() - u.y() * v.x()) / 2;
  e.slopes.row(1) = Vector2(v.y(), -v.x()).transpose() / (2 * e.area);
  e.slopes.row(2) = Vector2(-u.y(), u.x()).transpose() / (2 * e.area);
  e.slopes.row(0) = -e.slopes.row(1) - e.slopes.row(2);
  return e;
}

// Calls visit(element, shape values, gradients, point, weight) at every point of the rule.
template <class Visit>
void integrate(const std::vector<Element>& elements, Visit visit) {
  for (const Element& e : elements)
    for (const RulePoint& p : rule)
      visit(e, shape(p), e.gradients(p), e.point(p), p.weight * e.area);
}

// Nodal loads of the three problems, columns: torsion, shear along y, shear along z.
using Loads = Eigen::Matrix<double, Eigen::Dynamic, 3>;

// One piece in the principal axes at its centroid.
class Piece {
 public:
  Piece(const SectionPiece& outline, double poisson) : poisson_(poisson) {
    double area = 0;
    for (const Loop& loop : outline.loops) area += signed_area(loop);
    const SectionMesh linear = triangulate(outline, triangle_size(area, length(outline)));
    properties_.triangles = static_cast<int>(linear.triangles.size());
    properties_.holes = static_cast<int>(outline.loops.size()) - 1;
    properties_.pieces = 1;
    mesh_ = quadratic(linear);
    find_moments();
    to_principal_axes();
    solve();
    find_torsion();
    find_shear();
  }

  const SectionProperties& properties() const { return properties_; }

 private:
  static double length(const SectionPiece& outline) {
    double sum = 0;
    for (const Loop& loop : outline.loops)
      for (std::size_t i = 0; i < loop.size(); ++i)
        sum += (loop[(i + 1) % loop.size()] - loop[i]).norm();
    return sum;
  }

  // Four triangles across a plate of the mean thickness 2 A / P; of long thin walls one and a half,
  // for the warping across them is nearly linear.
  static double triangle_size(double area, double perimeter) {
    const double thickness = 2 * area / perimeter, affordable = std::sqrt(area / 800);
    return std::clamp(affordable, thickness / 4, thickness / 1.5);
  }

  void set_elements(const Vector2& origin) {
    elements_.clear();
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t)
      elements_.push_back(element(mesh_, t, origin));
  }

  void find_moments() {
    set_elements(mesh_.points.front());  // near the section: no cancellation
    Vector2 first = Vector2::Zero();
    integrate(elements_, [&](const Element&, const auto&, const auto&, const Vector2& p, double w) {
      properties_.area += w;
      first += w * p;
    });
    properties_.centroid = mesh_.points.front() + first / properties_.area;
    set_elements(properties_.centroid);
    integrate(elements_, [&](const Element&, const auto&, const auto&, const Vector2& p, double w) {
      properties_.second_moment += w * p * p.transpose();
    });
  }

  void to_principal_axes() {
    const auto principal = properties_.principal();
    axes_ = principal.axes;
    moments_ = principal.moments;
    for (Vector2& p : mesh_.points) p = axes_.transpose() * (p - properties_.centroid);
    set_elements(Vector2::Zero());
  }

  // What Poisson's ratio adds to the shear strain under a force along axis 0 (y) or 1 (z).
  Vector2 anticlastic(int force, const Vector2& p) const {
    const double y = p.x(), z = p.y();
    return force == 0 ? Vector2(poisson_ * (y * y - z * z) / 2, poisson_ * y * z)
                      : Vector2(poisson_ * y * z, poisson_ * (z * z - y * y) / 2);
  }

  // Laplace's equation for the warping function and the shear functions (Pilkey 5.42, 6.30, 6.33,
  // in principal axes); one node is held, for a constant does not matter.
  void solve() {
    const auto n = static_cast<Eigen::Index>(mesh_.points.size());
    std::vector<Eigen::Triplet<double>> entries;
    Loads loads = Loads::Zero(n, 3);
    for (const Element& e : elements_) {
      Eigen::Matrix<double, 6, 6> stiffness = Eigen::Matrix<double, 6, 6>::Zero();
      Eigen::Matrix<double, 6, 3> load = Eigen::Matrix<double, 6, 3>::Zero();
      for (const RulePoint& p : rule) {
        const Gradients g = e.gradients(p);
        const Vector2 r = e.point(p);
        const double w = p.weight * e.area;
        stiffness += w * g * g.transpose();
        load.col(0) += w * g * Vector2(r.y(), -r.x());
        for (int force = 0; force < 2; ++force)
          load.col(1 + force) +=
              w * (2 * (1 + poisson_) * r[force] * shape(p) + g * anticlastic(force, r));
      }
      for (Eigen::Index i = 0; i < 6; ++i) {
        const int row = e.nodes[at(i)];
        loads.row(row) += load.row(i);
        for (Eigen::Index j = 0; j < 6; ++j)
          if (const int column = e.nodes[at(j)]; row >= column && column > 0)
            entries.emplace_back(row - 1, column - 1, stiffness(i, j));
      }
    }
    Eigen::SparseMatrix<double> matrix(n - 1, n - 1);
    matrix.setFromTriplets(entries.begin(), entries.end());
    const Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> factor(matrix);
    if (factor.info() != Eigen::Success)
      throw SectionError("its warping function cannot be computed: it hangs together in a point");
    fields_ = Loads::Zero(n, 3);
    fields_.bottomRows(n - 1) = factor.solve(loads.bottomRows(n - 1));
    torsion_energy_ = fields_.col(0).dot(loads.col(0));
  }

  // J = Ip - integral of |grad omega|^2. The shear centre is where a force does no work on the
  // warping (Trefftz): y = -Izw / Iy, z = Iyw / Iz with omega taken about the centroid.
  void find_torsion() {
    properties_.torsion_constant = moments_.sum() - torsion_energy_;
    Vector2 moment = Vector2::Zero();  // integral of r omega dA
    integrate(elements_, [&](const Element& e, const Vector6Nodes& n, const auto&, const Vector2& r,
                             double w) { moment += w * n.dot(e.values(fields_.col(0))) * r; });
    shear_centre_ = {-moment.y() / moments_[1], moment.x() / moments_[0]};
    properties_.shear_centre = properties_.centroid + axes_ * shear_centre_;
  }

  // Shear stresses of unit forces through the shear centre, and their energy.
  void find_shear() {
    Matrix2 energy = Matrix2::Zero();
    Vector2 torque = Vector2::Zero();
    integrate(elements_,
              [&](const Element& e, const auto&, const Gradients& g, const Vector2& r, double w) {
                Matrix2 stress;  // columns: force along y, along z
                for (int force = 0; force < 2; ++force)
                  stress.col(force) =
                      (g.transpose() * e.values(fields_.col(1 + force)) - anticlastic(force, r)) /
                      (2 * (1 + poisson_) * moments_[force]);
                energy += w * stress.transpose() * stress;
                torque += w * (r.x() * stress.row(1) - r.y() * stress.row(0)).transpose();
              });
    // What the torque about the centroid lacks to that of a force through the shear centre is made
    // up for by torsion. There it does no work on the warping, which leaves a single square.
    const Vector2 lack = Vector2(-shear_centre_.y(), shear_centre_.x()) - torque;
    energy -= lack * lack.transpose() / properties_.torsion_constant;
    properties_.shear_compliance = axes_ * energy * axes_.transpose();
  }

  double poisson_;
  QuadraticMesh mesh_;
  std::vector<Element> elements_;
  Matrix2 axes_;
  Vector2 moments_;
  Loads fields_;
  double torsion_energy_ = 0;
  Vector2 shear_centre_;
  SectionProperties properties_;
};

// Bending keeps a common plane; torsion and shear act side by side.
SectionProperties side_by_side(const std::vector<SectionProperties>& parts) {
  SectionProperties whole;
  Vector2 first = Vector2::Zero(), weighted_centre = Vector2::Zero();
  Matrix2 shear_stiffness = Matrix2::Zero();
  for (const SectionProperties& part : parts) {
    const Matrix2 stiffness = part.shear_compliance.inverse();
    whole.area += part.area;
    first += part.area * part.centroid;
    whole.torsion_constant += part.torsion_constant;
    shear_stiffness += stiffness;
    // The shear flow of a force along y decides the z of the centre, and the other way round.
    weighted_centre += Vector2(stiffness(1, 1), stiffness(0, 0)).cwiseProduct(part.shear_centre);
    whole.pieces += part.pieces;
    whole.holes += part.holes;
    whole.triangles += part.triangles;
  }
  whole.centroid = first / whole.area;
  for (const SectionProperties& part : parts) {
    const Vector2 arm = part.centroid - whole.centroid;
    whole.second_moment += part.second_moment + part.area * arm * arm.transpose();
  }
  whole.shear_compliance = shear_stiffness.inverse();
  whole.shear_centre =
      weighted_centre.cwiseQuotient(Vector2(shear_stiffness(1, 1), shear_stiffness(0, 0)));
  return whole;
}

}  // namespace

SectionProperties::Principal SectionProperties::principal() const {
  Eigen::SelfAdjointEigenSolver<Matrix2> eigen;
  eigen.computeDirect(second_moment);
  Principal principal{.moments = eigen.eigenvalues().reverse(),
                      .axes = eigen.eigenvectors().rowwise().reverse(),
                      .shear_coefficients = Vector2::Zero()};
  // Of a circle or a square every axis is a principal one: take those of the plane.
  if (principal.moments[0] - principal.moments[1] < 1e-9 * principal.moments[0])
    principal.axes.setIdentity();
  if (principal.axes.col(0).sum() < 0) principal.axes.col(0) *= -1;
  principal.axes.col(1) = Vector2(-principal.axes(1, 0), principal.axes(0, 0));
  for (Eigen::Index k = 0; k < 2; ++k)
    principal.shear_coefficients[k] =
        1 / (area * principal.axes.col(k).dot(shear_compliance * principal.axes.col(k)));
  return principal;
}

SectionProperties analyse(const std::vector<SectionPiece>& section, double poisson) {
  if (section.empty()) throw SectionError("there is no material in it");
  std::vector<SectionProperties> parts;
  parts.reserve(section.size());
  for (const SectionPiece& piece : section) parts.push_back(Piece(piece, poisson).properties());
  return parts.size() == 1 ? parts.front() : side_by_side(parts);
}

}  // namespace kinetostat::fea
