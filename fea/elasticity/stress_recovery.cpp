#include "kinetostat/fea/elasticity/stress_recovery.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include <Eigen/Cholesky>

#include "kinetostat/common/index.h"
#include "kinetostat/common/several_processors.h"
#include "kinetostat/fea/elasticity/groups.h"

namespace kinetostat::fea {
namespace {

using common::at;

constexpr Eigen::Index components = 6;
// With fewer elements around it, a corner node borrows those of its neighbours.
constexpr std::size_t fewest_elements = 12;

// Stress from the displacement gradient h(a, b) = du_a/dx_b.
Vector6 stress_components(const Matrix3& h, const Material& material) {
  const double mu = material.mu(), pressure = material.lambda() * h.trace();
  Vector6 s;
  s << pressure + 2 * mu * h(0, 0), pressure + 2 * mu * h(1, 1), pressure + 2 * mu * h(2, 2),
      mu * (h(0, 1) + h(1, 0)), mu * (h(1, 2) + h(2, 1)), mu * (h(2, 0) + h(0, 2));
  return s;
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
constexpr int most_samples = 4;
using SamplePoints = Eigen::Matrix<double, 4, Eigen::Dynamic, 0, 4, most_samples>;
SamplePoints sample_points(int order) {
  if (order == 1) return Eigen::Vector4d::Constant(0.25);
  const double near = (5 + 3 * std::sqrt(5.0)) / 20, far = (5 - std::sqrt(5.0)) / 20;
  Eigen::Matrix4d points = Eigen::Matrix4d::Constant(far);
  points.diagonal().setConstant(near);
  return points;
}

// out[i] = sum over k of weight[k] * values[k][i]: the stresses at one sample point from those at
// the four corners, which lie one behind the other.
KINETOSTAT_FOR_SEVERAL_PROCESSORS
void weighted_sum(const double* weight, const double* values, int width, double* __restrict out) {
  for (int i = 0; i < width; ++i)
    out[i] = weight[0] * values[i] + weight[1] * values[width + i] +
             weight[2] * values[2 * width + i] + weight[3] * values[3 * width + i];
}

// sums[i][j] += a[i] * b[j].
KINETOSTAT_FOR_SEVERAL_PROCESSORS
void add_product(const double* a, int rows, const double* b, int columns, double* __restrict sums) {
  for (int i = 0; i < rows; ++i)
    for (int j = 0; j < columns; ++j) sums[i * columns + j] += a[i] * b[j];
}

// The same for four pairs at once.
KINETOSTAT_FOR_SEVERAL_PROCESSORS
void add_four_products(const double* a, int rows, const double* b, int columns,
                       double* __restrict sums) {
  for (int i = 0; i < rows; ++i) {
    const double a0 = a[i], a1 = a[rows + i], a2 = a[2 * rows + i], a3 = a[3 * rows + i];
    for (int j = 0; j < columns; ++j)
      sums[i * columns + j] +=
          a0 * b[j] + a1 * b[columns + j] + a2 * b[2 * columns + j] + a3 * b[3 * columns + j];
  }
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

// Polynomials row by row: one row per term, one column per stress.
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// The elements and the free faces around each corner node.
struct Neighbourhood {
  const TetMesh& mesh;
  std::size_t material;  // of the elements
  Groups elements, free_faces;

  Neighbourhood(const TetMesh& solid, std::size_t number) : mesh(solid), material(number) {
    elements = group(mesh.nodes.size(), mesh.element_count(), [&](std::size_t e) {
      return mesh.element(e).first(mesh.material_of(e) == material ? 4 : 0);
    });
    free_faces = group(mesh.nodes.size(), mesh.boundary.size(), [&](std::size_t f) {
      const BoundaryFace& face = mesh.boundary[f];
      return std::span(face.nodes).first(face.tag == 0 ? 3 : 0);
    });
  }
};

// One patch after the other; the matrices of the last one are reused.
class Patch {
 public:
  Patch(const Neighbourhood& around, const Stresses& at_corners)
      : around_(around),
        mesh_(around.mesh),
        stresses_(at_corners),
        points_(sample_points(around.mesh.order)),
        terms_count_(term_count(around.mesh.order)) {}

  // The fitted polynomial in (x - node) / scale; returns the scale [m].
  double fit(int node, Eigen::Ref<RowMajor> polynomial) {
    choose_elements(node);
    centre_ = position(node);
    scale_ = 0;
    for (const int e : elements_)
      for (const Vector3& p : mesh_.corners(at(e))) scale_ = std::max(scale_, (p - centre_).norm());
    // The normal matrix stands right of the right-hand sides.
    const Eigen::Index width = stresses_.rows();
    sums_.setZero(terms_count_, width + terms_count_);
    for (const int e : elements_) add_samples(e);
    normal_ = sums_.rightCols(terms_count_);
    // A patch that lies in a plane or a line leaves terms undetermined: they shall be small.
    normal_.diagonal().array() += 1e-9 * normal_.trace();
    if (around_.free_faces.of(node).empty())
      polynomial = normal_.llt().solve(sums_.leftCols(width));
    else
      solve_with_tractions(node, polynomial);
    return scale_;
  }

 private:
  using Normal = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 10, 10>;

  const Vector3& position(int node) const { return mesh_.nodes[at(node)]; }
  Terms terms(const Vector3& x) const { return terms_at((x - centre_) / scale_, mesh_.order); }

  void choose_elements(int node) {
    const auto near = around_.elements.of(node);
    elements_.assign(near.begin(), near.end());
    if (elements_.size() >= fewest_elements) return;
    for (const int e : near)
      for (const int neighbour : mesh_.element(at(e)).first(4)) {
        const auto more = around_.elements.of(neighbour);
        elements_.insert(elements_.end(), more.begin(), more.end());
      }
    sort_unique(elements_);
  }

  Vector3 place_of_sample(int e, Eigen::Index q) const {
    const auto element = at(e);
    const Eigen::Vector4d l = points_.col(q);
    Vector3 x = Vector3::Zero();
    if (mesh_.curved) {
      const std::array<Vector3, 10> nodes = mesh_.all_nodes(element);
      for (std::size_t k = 0; k < 4; ++k) {
        const double share = l[static_cast<Eigen::Index>(k)];
        x += share * (2 * share - 1) * nodes[k];
      }
      for (std::size_t k = 0; k < tet_edges.size(); ++k)
        x += 4 * l[tet_edges[k][0]] * l[tet_edges[k][1]] * nodes[4 + k];
      return x;
    }
    const std::array<Vector3, 4> corners = mesh_.corners(element);
    for (std::size_t k = 0; k < 4; ++k) x += l[static_cast<Eigen::Index>(k)] * corners[k];
    return x;
  }

  void add_samples(int e) {
    const int rows = static_cast<int>(terms_count_), width = static_cast<int>(stresses_.rows());
    factors_.resize(points_.cols(), terms_count_);
    samples_.resize(points_.cols(), sums_.cols());
    for (Eigen::Index q = 0; q < points_.cols(); ++q) {
      factors_.row(q) = terms(place_of_sample(e, q)).transpose();
      weighted_sum(points_.col(q).data(), stresses_.col(4 * Eigen::Index{e}).data(), width,
                   samples_.row(q).data());
      samples_.row(q).tail(terms_count_) = factors_.row(q);
    }
    const auto add = points_.cols() == most_samples ? add_four_products : add_product;
    add(factors_.data(), rows, samples_.data(), static_cast<int>(sums_.cols()), sums_.data());
  }

  // A traction couples the six components of the stress: one system for all of them.
  void solve_with_tractions(int node, Eigen::Ref<RowMajor> polynomial) {
    const Eigen::Index n = terms_count_, cases = stresses_.rows() / components;
    coupled_.setZero(components * n, components * n);
    for (Eigen::Index i = 0; i < components; ++i) coupled_.block(i * n, i * n, n, n) = normal_;
    for (const int f : around_.free_faces.of(node)) add_tractions(mesh_.boundary[at(f)]);
    by_case_.resize(components * n, cases);
    for (Eigen::Index c = 0; c < cases; ++c)
      for (Eigen::Index i = 0; i < components; ++i)
        by_case_.block(i * n, c, n, 1) = sums_.col(components * c + i);
    Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>>(coupled_).solveInPlace(by_case_);
    for (Eigen::Index c = 0; c < cases; ++c)
      for (Eigen::Index i = 0; i < components; ++i)
        polynomial.col(components * c + i) = by_case_.block(i * n, c, n, 1);
  }

  void add_tractions(const BoundaryFace& face) {
    for (std::size_t side = 0; side < 3; ++side) {
      const Vector3 &a = position(face.nodes[side]), &b = position(face.nodes[(side + 1) % 3]),
                    &c = position(face.nodes[(side + 2) % 3]);
      Vector3 middle = (a + b) / 2, across = c - middle;
      if (mesh_.curved) {
        middle = position(face.nodes[3 + side]);
        across = 2 * (position(face.nodes[3 + (side + 1) % 3]) +
                      position(face.nodes[3 + (side + 2) % 3]) - middle) -
                 (a + b) / 2 - c;
      }
      add_traction(middle, (b - a).cross(across).normalized());
    }
  }

  // To the lower triangle, for a point of the surface with this normal.
  void add_traction(const Vector3& x, const Vector3& normal) {
    const auto t = traction(normal);
    const Eigen::Matrix<double, 6, 6> square = t.transpose() * t;
    const Terms m = terms(x);
    const Normal products = m * m.transpose();
    for (Eigen::Index i = 0; i < components; ++i)
      for (Eigen::Index j = 0; j <= i; ++j)
        if (square(i, j) != 0)
          coupled_.block(i * terms_count_, j * terms_count_, terms_count_, terms_count_) +=
              square(i, j) * products;
  }

  const Neighbourhood& around_;
  const TetMesh& mesh_;
  const Stresses& stresses_;
  const SamplePoints points_;
  const Eigen::Index terms_count_;

  Vector3 centre_;  // [m]
  double scale_ = 1;
  std::vector<int> elements_;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor, most_samples, 10> factors_;
  RowMajor samples_, sums_;
  Normal normal_;
  Eigen::MatrixXd coupled_, by_case_;
};

class Recovery {
 public:
  Recovery(const TetMesh& mesh, const Stresses& at_corners, std::size_t material,
           common::ThreadPool& pool)
      : mesh_(mesh),
        around_(mesh, material),
        stresses_(at_corners),
        pool_(pool),
        place_(mesh.nodes.size(), -1) {
    for (std::size_t n = 0; n < place_.size(); ++n)
      if (!around_.elements.of(static_cast<int>(n)).empty()) {
        place_[n] = static_cast<int>(corners_.size());
        corners_.push_back(static_cast<int>(n));
      }
  }

  Stresses all() {
    Stresses result =
        Stresses::Zero(stresses_.rows(), static_cast<Eigen::Index>(mesh_.nodes.size()));
    fit_corners(result);
    if (mesh_.order == 2) take_means(result);
    return result;
  }

 private:
  static constexpr std::size_t at_once = 256;

  Eigen::Index terms_count() const { return term_count(mesh_.order); }
  auto polynomial(std::size_t place) {
    return polynomials_.middleRows(static_cast<Eigen::Index>(place) * terms_count(), terms_count());
  }

  void fit_corners(Stresses& result) {
    polynomials_.resize(static_cast<Eigen::Index>(corners_.size()) * terms_count(),
                        stresses_.rows());
    scales_.resize(corners_.size());
    pool_.for_each_piece(corners_.size(), at_once, [&](int, std::size_t begin, std::size_t end) {
      Patch patch(around_, stresses_);
      for (std::size_t i = begin; i < end; ++i) {
        scales_[i] = patch.fit(corners_[i], polynomial(i));
        result.col(corners_[i]) = polynomial(i).row(0).transpose();  // its own coordinates are 0
      }
    });
  }

  void take_means(Stresses& result) {
    std::vector<std::array<int, 2>> ends(mesh_.nodes.size(), {-1, -1});
    for (std::size_t e = 0; e < mesh_.element_count(); ++e) {
      if (mesh_.material_of(e) != around_.material) continue;
      const auto element = mesh_.element(e);
      for (std::size_t k = 0; k < tet_edges.size(); ++k)
        ends[at(element[4 + k])] = {element[at(tet_edges[k][0])], element[at(tet_edges[k][1])]};
    }
    pool_.for_each_piece(ends.size(), at_once, [&](int, std::size_t begin, std::size_t last) {
      for (std::size_t n = begin; n < last; ++n)
        for (const int end : ends[n]) {
          if (end < 0) continue;
          const auto p = at(place_[at(end)]);
          const Terms at_middle =
              terms_at((mesh_.nodes[n] - mesh_.nodes[at(end)]) / scales_[p], mesh_.order);
          result.col(static_cast<Eigen::Index>(n)) += 0.5 * (polynomial(p).transpose() * at_middle);
        }
    });
  }

  const TetMesh& mesh_;
  const Neighbourhood around_;
  const Stresses& stresses_;
  common::ThreadPool& pool_;
  std::vector<int> corners_, place_;  // nodes with a polynomial, and the place of each in the list
  RowMajor polynomials_;              // one below the other
  std::vector<double> scales_;        // [m]
};

// Rows: the components of the displacements of all load cases, at the nodes of one element.
void gather(std::span<const int> element, const std::vector<Eigen::Matrix3Xd>& displacements,
            Eigen::MatrixXd& at_nodes) {
  at_nodes.resize(3 * static_cast<Eigen::Index>(displacements.size()),
                  static_cast<Eigen::Index>(element.size()));
  for (std::size_t c = 0; c < displacements.size(); ++c)
    for (std::size_t n = 0; n < element.size(); ++n)
      at_nodes.block<3, 1>(3 * static_cast<Eigen::Index>(c), static_cast<Eigen::Index>(n)) =
          displacements[c].col(element[n]);
}

// Stresses at one place of an element, all load cases one below the other.
class ElementStresses {
 public:
  ElementStresses(const TetMesh& mesh, std::size_t e, const Material& material,
                  const std::vector<Eigen::Matrix3Xd>& displacements)
      : order_(mesh.order),
        curved_(mesh.curved),
        material_(material),
        gradients_(barycentric_gradients(mesh.corners(e))) {
    gather(mesh.element(e), displacements, at_nodes_);
    if (!curved_) return;
    const std::array<Vector3, 10> nodes = mesh.all_nodes(e);
    for (std::size_t n = 0; n < nodes.size(); ++n)
      nodes_.col(static_cast<Eigen::Index>(n)) = nodes[n];
  }

  template <class Column>
  void at(const Eigen::Vector4d& place, Column out) {
    const Eigen::Matrix3Xd shapes = shape_gradients(gradients_, order_, place);
    slopes_ = at_nodes_.lazyProduct(shapes.transpose());
    // From the straight element with these corners to the curved one.
    if (curved_) slopes_ *= Matrix3(nodes_ * shapes.transpose()).inverse();
    for (Eigen::Index c = 0; c < slopes_.rows() / 3; ++c)
      out.template segment<6>(components * c) =
          stress_components(slopes_.middleRows<3>(3 * c), material_);
  }

 private:
  int order_;
  bool curved_;
  const Material& material_;
  BarycentricGradients gradients_;
  Eigen::MatrixXd at_nodes_;
  Eigen::Matrix<double, 3, 10> nodes_;
  Eigen::Matrix<double, Eigen::Dynamic, 3> slopes_;
};

}  // namespace

Stresses corner_stresses(const TetMesh& mesh, const std::vector<Material>& materials,
                         const std::vector<Eigen::Matrix3Xd>& displacements,
                         common::ThreadPool& pool) {
  constexpr std::size_t at_once = 1024;
  Stresses result(components * static_cast<Eigen::Index>(displacements.size()),
                  4 * static_cast<Eigen::Index>(mesh.element_count()));
  // The stresses of a curved element are not linear: the linear ones with the same values where
  // they are most accurate stand for them.
  const SamplePoints places =
      mesh.curved ? sample_points(2) : SamplePoints(Eigen::Matrix4d::Identity());
  const Eigen::Matrix4d to_corners = Eigen::Matrix4d(places).inverse();
  pool.for_each_piece(mesh.element_count(), at_once, [&](int, std::size_t begin, std::size_t end) {
    for (std::size_t e = begin; e < end; ++e) {
      ElementStresses stresses(mesh, e, materials[mesh.material_of(e)], displacements);
      auto columns = result.middleCols<4>(4 * static_cast<Eigen::Index>(e));
      for (Eigen::Index k = 0; k < 4; ++k) stresses.at(places.col(k), columns.col(k));
      if (mesh.curved) columns = (columns * to_corners).eval();
    }
  });
  return result;
}

Vector6 strain_of(const Eigen::Ref<const Vector6>& s, const Material& material) {
  const double direct = (1 + material.poisson()) / material.young();
  const double lateral = material.poisson() / material.young();
  Vector6 result;
  result.head<3>() = direct * s.head<3>().array() - lateral * s.head<3>().sum();
  result.tail<3>() = 2 * direct * s.tail<3>();
  return result;
}

Stresses recovered_stresses(const TetMesh& mesh, const Stresses& at_corners, std::size_t material,
                            common::ThreadPool& pool) {
  return Recovery(mesh, at_corners, material, pool).all();
}

}  // namespace kinetostat::fea
