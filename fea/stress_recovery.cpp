#include "kinetostat/fea/stress_recovery.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include <Eigen/Cholesky>

namespace kinetostat::fea {
namespace {

constexpr Eigen::Index components = 6;
// With fewer elements around it, a corner node borrows those of its neighbours.
constexpr std::size_t fewest_elements = 12;

// Stress from the displacement gradient h(a, b) = du_a/dx_b.
Vector6 stress_of(const Matrix3& h, const Material& material) {
  const double mu = material.mu(), pressure = material.lambda() * h.trace();
  Vector6 s;
  s << pressure + 2 * mu * h(0, 0), pressure + 2 * mu * h(1, 1), pressure + 2 * mu * h(2, 2),
      mu * (h(0, 1) + h(1, 0)), mu * (h(1, 2) + h(2, 1)), mu * (h(2, 0) + h(0, 2));
  return s;
}

// Items grouped by owner: those of owner i are item[start[i]] to item[start[i + 1] - 1].
struct Groups {
  std::vector<int> start, item;

  std::span<const int> of(int owner) const {
    const auto first = static_cast<std::size_t>(start[static_cast<std::size_t>(owner)]);
    const auto last = static_cast<std::size_t>(start[static_cast<std::size_t>(owner) + 1]);
    return std::span(item).subspan(first, last - first);
  }
};

// `owners_of(i)` are the owners of item i.
template <class OwnersOf>
Groups group(std::size_t owners, std::size_t items, OwnersOf owners_of) {
  Groups groups{std::vector<int>(owners + 1, 0), {}};
  for (std::size_t i = 0; i < items; ++i)
    for (const int owner : owners_of(i)) ++groups.start[static_cast<std::size_t>(owner) + 1];
  for (std::size_t o = 0; o < owners; ++o) groups.start[o + 1] += groups.start[o];
  groups.item.resize(static_cast<std::size_t>(groups.start.back()));
  std::vector<int> next(groups.start.begin(), groups.start.end() - 1);
  for (std::size_t i = 0; i < items; ++i)
    for (const int owner : owners_of(i))
      groups.item[static_cast<std::size_t>(next[static_cast<std::size_t>(owner)]++)] =
          static_cast<int>(i);
  return groups;
}

Eigen::Index term_count(int order) { return order == 1 ? 4 : 10; }

// Products of powers of x, y, z up to the order.
using Terms = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 10, 1>;
Terms terms_at(const Vector3& x, int order) {
  Terms t(term_count(order));
  t.head<4>() << 1, x;
  if (order == 2)
    t.tail<6>() << x.x() * x.x(), x.y() * x.y(), x.z() * x.z(), x.x() * x.y(), x.y() * x.z(),
        x.z() * x.x();
  return t;
}

// Where the stresses of an element are most accurate: at its centre when they are constant, at the
// four points of the quadrature when they are linear. Barycentric coordinates in the columns.
Eigen::Matrix4Xd sample_points(int order) {
  if (order == 1) return Eigen::Vector4d::Constant(0.25);
  const double near = (5 + 3 * std::sqrt(5.0)) / 20, far = (5 - std::sqrt(5.0)) / 20;
  Eigen::Matrix4d points = Eigen::Matrix4d::Constant(far);
  points.diagonal().setConstant(near);
  return points;
}

// The traction on a face with unit normal n, as rows times the stress.
Eigen::Matrix<double, 3, 6> traction(const Vector3& n) {
  Eigen::Matrix<double, 3, 6> t;
  t << n.x(), 0, 0, n.y(), 0, n.z(),  //
      0, n.y(), 0, n.x(), n.z(), 0,   //
      0, 0, n.z(), 0, n.y(), n.x();
  return t;
}

void sort_unique(std::vector<int>& items) {
  std::sort(items.begin(), items.end());
  items.erase(std::unique(items.begin(), items.end()), items.end());
}

// One patch after the other; the matrices of the last one are reused.
class Recovery {
 public:
  Recovery(const TetMesh& mesh, const Stresses& at_corners, std::size_t material)
      : mesh_(mesh), stresses_(at_corners), points_(sample_points(mesh.order)) {
    elements_ = group(mesh.nodes.size(), mesh.element_count(), [&](std::size_t e) {
      return mesh.element(e).first(mesh.material_of(e) == material ? 4 : 0);
    });
    free_faces_ = group(mesh.nodes.size(), mesh.boundary.size(), [&](std::size_t f) {
      const BoundaryFace& face = mesh.boundary[f];
      return std::span(face.nodes).first(face.tag == 0 ? 3 : 0);
    });
  }

  Stresses all() {
    Stresses result =
        Stresses::Zero(stresses_.rows(), static_cast<Eigen::Index>(mesh_.nodes.size()));
    for (int node = 0; node < static_cast<int>(mesh_.nodes.size()); ++node) {
      if (elements_.of(node).empty()) continue;
      choose_elements(node);
      fit(node);
      result.col(node) = polynomials_.row(0).transpose();  // its local coordinates are 0
      if (mesh_.order == 2) add_to_middles(node, result);
    }
    return result;
  }

 private:
  const Vector3& position(int node) const { return mesh_.nodes[static_cast<std::size_t>(node)]; }
  Terms terms(const Vector3& x) const { return terms_at((x - centre_) / scale_, mesh_.order); }

  void choose_elements(int node) {
    const auto around = elements_.of(node);
    patch_.assign(around.begin(), around.end());
    if (patch_.size() >= fewest_elements) return;
    for (const int e : around)
      for (const int neighbour : mesh_.element(static_cast<std::size_t>(e)).first(4)) {
        const auto more = elements_.of(neighbour);
        patch_.insert(patch_.end(), more.begin(), more.end());
      }
    sort_unique(patch_);
  }

  void fit(int node) {
    centre_ = position(node);
    scale_ = 0;
    for (const int e : patch_)
      for (const Vector3& p : mesh_.corners(static_cast<std::size_t>(e)))
        scale_ = std::max(scale_, (p - centre_).norm());
    normal_.setZero(term_count(mesh_.order), term_count(mesh_.order));
    polynomials_.setZero(term_count(mesh_.order), stresses_.rows());
    for (const int e : patch_) add_samples(e);
    // A patch that lies in a plane or a line leaves terms undetermined: they shall be small.
    normal_.diagonal().array() += 1e-9 * normal_.trace();
    if (free_faces_.of(node).empty())
      polynomials_ = normal_.llt().solve(polynomials_);
    else
      solve_with_tractions(node);
  }

  void add_samples(int e) {
    const std::array<Vector3, 4> corners = mesh_.corners(static_cast<std::size_t>(e));
    const Eigen::MatrixXd samples = stresses_.middleCols<4>(4 * Eigen::Index{e}) * points_;
    for (Eigen::Index q = 0; q < points_.cols(); ++q) {
      Vector3 x = Vector3::Zero();
      for (Eigen::Index k = 0; k < 4; ++k)
        x += points_(k, q) * corners[static_cast<std::size_t>(k)];
      const Terms t = terms(x);
      normal_.noalias() += t * t.transpose();
      polynomials_.noalias() += t * samples.col(q).transpose();
    }
  }

  // A traction couples the six components of the stress: one system for all of them.
  void solve_with_tractions(int node) {
    const Eigen::Index n = normal_.rows();
    coupled_.setZero(components * n, components * n);
    for (Eigen::Index i = 0; i < components; ++i) coupled_.block(i * n, i * n, n, n) = normal_;
    for (const int f : free_faces_.of(node))
      add_tractions(mesh_.boundary[static_cast<std::size_t>(f)]);
    // The six components of a load case lie below one another.
    Eigen::Map<Eigen::MatrixXd> by_case(polynomials_.data(), components * n,
                                        stresses_.rows() / components);
    by_case = coupled_.llt().solve(by_case).eval();
  }

  void add_tractions(const BoundaryFace& face) {
    const Vector3 &a = position(face.nodes[0]), &b = position(face.nodes[1]),
                  &c = position(face.nodes[2]);
    const auto t = traction((b - a).cross(c - a).normalized());
    const Eigen::Matrix<double, 6, 6> square = t.transpose() * t;
    const Eigen::Index n = normal_.rows();
    for (const Vector3& x : {Vector3((a + b) / 2), Vector3((b + c) / 2), Vector3((c + a) / 2)}) {
      const Terms m = terms(x);
      for (Eigen::Index i = 0; i < components; ++i)
        for (Eigen::Index j = 0; j < components; ++j)
          if (square(i, j) != 0)
            coupled_.block(i * n, j * n, n, n).noalias() += square(i, j) * m * m.transpose();
    }
  }

  void add_to_middles(int node, Stresses& result) {
    middles_.clear();
    for (const int e : elements_.of(node)) {
      const auto element = mesh_.element(static_cast<std::size_t>(e));
      for (std::size_t k = 0; k < tet_edges.size(); ++k)
        for (const int end : tet_edges[k])
          if (element[static_cast<std::size_t>(end)] == node) middles_.push_back(element[4 + k]);
    }
    sort_unique(middles_);
    for (const int middle : middles_)
      result.col(middle) += 0.5 * polynomials_.transpose() * terms(position(middle));
  }

  const TetMesh& mesh_;
  const Stresses& stresses_;
  const Eigen::Matrix4Xd points_;
  Groups elements_, free_faces_;

  Vector3 centre_;  // [m]
  double scale_ = 1;
  std::vector<int> patch_, middles_;
  Eigen::MatrixXd normal_, coupled_;
  Eigen::MatrixXd polynomials_;  // one row per term; right-hand sides until the system is solved
};

}  // namespace

Stresses corner_stresses(const TetMesh& mesh, const std::vector<Material>& materials,
                         const std::vector<Eigen::Matrix3Xd>& displacements) {
  Stresses result(components * static_cast<Eigen::Index>(displacements.size()),
                  4 * static_cast<Eigen::Index>(mesh.element_count()));
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    const auto element = mesh.element(e);
    const Material& material = materials[mesh.material_of(e)];
    const BarycentricGradients gradients = barycentric_gradients(mesh.corners(e));
    for (Eigen::Index k = 0; k < 4; ++k) {
      const Eigen::Matrix3Xd shapes =
          shape_gradients(gradients, mesh.order, Eigen::Vector4d::Unit(k));
      for (std::size_t c = 0; c < displacements.size(); ++c) {
        Matrix3 h = Matrix3::Zero();
        for (std::size_t n = 0; n < element.size(); ++n)
          h += displacements[c].col(element[n]) *
               shapes.col(static_cast<Eigen::Index>(n)).transpose();
        result.block<6, 1>(components * static_cast<Eigen::Index>(c),
                           4 * static_cast<Eigen::Index>(e) + k) = stress_of(h, material);
      }
    }
  }
  return result;
}

Stresses recovered_stresses(const TetMesh& mesh, const Stresses& at_corners, std::size_t material) {
  return Recovery(mesh, at_corners, material).all();
}

}  // namespace kinetostat::fea
