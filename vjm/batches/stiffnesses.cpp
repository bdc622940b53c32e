// Stiffness of relaxed robots in many postures: four at a time.
#include <algorithm>

#include "kinetostat/vjm/batches/batches.h"
#include "kinetostat/vjm/batches/relaxed_chain.h"
#include "kinetostat/vjm/statics/stiffness.h"

namespace kinetostat::vjm {
namespace {

using Eigen::Index;
using spatial::Matrix6;
using Coordinates = RelaxedChain::Coordinates;

// What is far enough from a dependence to go without pivots; the others go alone.
constexpr double clear = 1e-5;

void multiply(const Matrix3Lanes& a, const Matrix3Lanes& b, Matrix3Lanes& product) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      product(i, j) = a(i, 0) * b(0, j) + a(i, 1) * b(1, j) + a(i, 2) * b(2, j);
}

// R A R'.
template <class Block>
void turn(const Matrix3Lanes& r, const Block& a, Matrix3Lanes& turned) {
  Matrix3Lanes half;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      half(i, j) = r(i, 0) * a(0, j) + r(i, 1) * a(1, j) + r(i, 2) * a(2, j);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      turned(i, j) = half(i, 0) * r(j, 0) + half(i, 1) * r(j, 1) + half(i, 2) * r(j, 2);
}

// Adds the compliance of the springs of a segment as it is felt at the end: with the twist there
// v + w x arm,  A + S B' + X S',  X = B + S D,  D  with  S w = w x arm. The lower triangle.
void add_segment(const RelaxedChain::Segment& segment, const RelaxedKinematics& at,
                 Matrix6Lanes& compliance) {
  const auto j = static_cast<std::size_t>(segment.joints);
  const Matrix6& c = segment.compliance;
  Matrix3Lanes a, b, d, s, x;
  turn(at.rotations[j], c.topLeftCorner<3, 3>(), a);
  turn(at.rotations[j], c.topRightCorner<3, 3>(), b);
  turn(at.rotations[j], c.bottomRightCorner<3, 3>(), d);
  Lanes arm[3];
  for (int i = 0; i < 3; ++i) arm[i] = at.position[i] - at.positions[j][i];
  const Lanes zero(0.0);
  s << zero, arm[2], -arm[1], -arm[2], zero, arm[0], arm[1], -arm[0], zero;
  multiply(s, d, x);
  for (int k = 0; k < 9; ++k) x.data()[k] += b.data()[k];
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k <= i; ++k) {
      Lanes sum = a(i, k);
      for (int m = 0; m < 3; ++m) sum += s(i, m) * b(k, m) + x(i, m) * s(k, m);
      compliance(i, k) += sum;
      compliance(3 + i, 3 + k) += d(i, k);
    }
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) compliance(3 + i, k) += x(k, i);
}

// Householder's reflections of the columns of some twists, which are clearly independent in the
// lanes of `good`.
struct Reflections {
  Matrix6Lanes vectors;  // column by column, of length sqrt(2)
  int count = 0;
  LaneMask good = LaneMask::all();

  // The reflection of a column that the earlier ones are applied to first.
  void add(Lanes (&column)[6]) {
    Lanes whole(0.0), left(0.0);
    for (int i = 0; i < 6; ++i) whole += column[i] * column[i];
    for (int k = 0; k < count; ++k) apply(k, column);
    for (int i = count; i < 6; ++i) left += column[i] * column[i];
    good = good & (left > whole * (clear * clear)) & (whole > 0.0);
    const Lanes length = sqrt(left);
    const Lanes first = column[count], sign = Lanes::chosen(first < 0.0, -1.0, 1.0);
    // v = x + sign |x| e, v'v = 2 (|x|^2 + |x| |x_1|)
    const Lanes scale = 1.0 / sqrt(left + length * abs(first));
    for (int i = 0; i < 6; ++i) vectors(i, count) = i < count ? Lanes(0.0) : column[i] * scale;
    vectors(count, count) = (first + sign * length) * scale;
    ++count;
  }
  void apply(int k, Lanes (&x)[6]) const {
    Lanes share(0.0);
    for (int i = k; i < 6; ++i) share += vectors(i, k) * x[i];
    for (int i = k; i < 6; ++i) x[i] -= share * vectors(i, k);
  }
};

// N (N' C N)^-1 N' with N the wrenches that the reflected columns do not work on, in the lower
// triangle; the lanes in which that can be relied on.
LaneMask add_transmitted(const Reflections& passive, const Matrix6Lanes& compliance, Lanes length,
                         Matrix6Lanes& stiffness) {
  const int n = 6 - passive.count;
  Matrix6Lanes basis, felt, reduced;
  for (int j = 0; j < n; ++j) {
    Lanes column[6];
    for (int i = 0; i < 6; ++i) column[i] = i == passive.count + j ? 1.0 : 0.0;
    for (int k = passive.count; k-- > 0;) passive.apply(k, column);
    for (int i = 0; i < 6; ++i) basis(i, j) = column[i];
  }
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < 6; ++i) {
      Lanes sum(0.0);
      for (int k = 0; k < 6; ++k) sum += compliance(std::max(i, k), std::min(i, k)) * basis(k, j);
      felt(i, j) = sum;
    }
  Lanes largest = compliance(0, 0), smallest(0.0);
  for (int i = 1; i < 6; ++i) largest = max(largest, compliance(i, i));
  for (int j = 0; j < n; ++j)  // Cholesky's factor of N'CN, row by row
    for (int i = 0; i <= j; ++i) {
      Lanes sum(0.0);
      for (int k = 0; k < 6; ++k) sum += basis(k, j) * felt(k, i);
      for (int k = 0; k < i; ++k) sum -= reduced(j, k) * reduced(i, k);
      if (i < j) {
        reduced(j, i) = sum * reduced(i, i);
        continue;
      }
      smallest = j == 0 ? sum : min(smallest, sum);
      reduced(j, j) = 1.0 / sqrt(sum);
    }
  for (int i = 0; i < 6; ++i)  // N L^-T in place, and its product with its transpose
    for (int j = 0; j < n; ++j) {
      Lanes sum = basis(i, j);
      for (int k = 0; k < j; ++k) sum -= reduced(j, k) * basis(i, k);
      basis(i, j) = sum * reduced(j, j);
    }
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j <= i; ++j) {
      Lanes sum(0.0);
      for (int k = 0; k < n; ++k) sum += basis(i, k) * basis(j, k);
      stiffness(i, j) += sum * (i < 3 ? Lanes(1.0) : length) * (j < 3 ? Lanes(1.0) : length);
    }
  return smallest > largest * (clear * clear);
}

// Adds the stiffness of one chain at its end in base axes to the lower triangle; the lanes in which
// neither a singular posture nor a rigid chain is near.
LaneMask add_stiffness(const RelaxedChain& chain, const Coordinates& x, Matrix6Lanes& stiffness) {
  RelaxedKinematics at;
  evaluate(chain, x, at);
  RelaxedChain::Twists twists;
  twists_of(chain, at, twists);
  Lanes reach(0.0);
  for (std::size_t j = 0; j < chain.joints.size(); ++j) {
    Lanes squared(0.0);
    for (int i = 0; i < 3; ++i) {
      const Lanes arm = at.position[i] - at.origins[j][i];
      squared += arm * arm;
    }
    reach = max(reach, squared);
  }
  const Lanes length = Lanes::chosen(reach > 0.0, sqrt(reach), 1.0);  // as it scales rotations
  Matrix6Lanes compliance;
  for (int k = 0; k < 36; ++k) compliance.data()[k] = 0.0;
  for (const RelaxedChain::Segment& segment : chain.segments) add_segment(segment, at, compliance);
  Reflections passive;
  for (std::size_t k = 0; k < chain.chosen.size(); ++k) {
    const auto column = static_cast<Index>(k);
    if (const double c = chain.chosen[k].compliance; c != 0)
      for (int i = 0; i < 6; ++i)
        for (int j = 0; j <= i; ++j) compliance(i, j) += twists(i, column) * c * twists(j, column);
    if (!chain.chosen[k].is_free) continue;
    if (passive.count == 5) return LaneMask();
    Lanes scaled[6];
    for (int i = 0; i < 6; ++i) scaled[i] = twists(i, column) * (i < 3 ? Lanes(1.0) : length);
    passive.add(scaled);
  }
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j <= i; ++j)
      compliance(i, j) *= (i < 3 ? Lanes(1.0) : length) * (j < 3 ? Lanes(1.0) : length);
  return passive.good & add_transmitted(passive, compliance, length, stiffness);
}

// The coordinates of a chain in up to four postures, of which the last fills what is left.
Coordinates gathered(const RelaxedChain& chain, const std::vector<Posture>& postures,
                     std::size_t first, std::size_t c) {
  Coordinates x(static_cast<Index>(chain.chosen.size()));
  for (int lane = 0; lane < lane_count; ++lane) {
    const std::size_t i = piece_of(first, lane, postures.size());
    for (Index k = 0; k < x.size(); ++k)
      x[k].set(lane,
               postures[i].coordinates[c][chain.chosen[static_cast<std::size_t>(k)].coordinate]);
  }
  return x;
}

}  // namespace

std::vector<std::optional<spatial::Stiffness6>> unloaded_stiffness_matrices(
    const Manipulator& manipulator, const std::vector<Posture>& postures) {
  if (manipulator.has_errors())
    return unloaded_stiffness_matrices(manipulator.without_errors(), postures);
  std::vector<std::optional<spatial::Stiffness6>> results(postures.size());
  const auto& all = manipulator.chains();
  // What laws of joints add depends on where those stand.
  const bool is_linear =
      std::all_of(all.begin(), all.end(), [](const Chain& chain) { return chain.laws().empty(); });
  const std::vector<RelaxedChain> chains =
      manipulator.is_parallel() && is_linear ? relaxed_chains(all) : std::vector<RelaxedChain>();
  for (std::size_t first = 0; first < postures.size(); first += lane_count) {
    Matrix6Lanes sum;
    for (int k = 0; k < 36; ++k) sum.data()[k] = 0.0;
    LaneMask good = chains.empty() ? LaneMask() : LaneMask::all();
    for (std::size_t c = 0; c < chains.size(); ++c)
      in_lanes([&, x = gathered(chains[c], postures, first, c)] {
        good = good & add_stiffness(chains[c], x, sum);
      });
    for (std::size_t i = first; i < std::min(first + lane_count, postures.size()); ++i) {
      const auto lane = static_cast<int>(i - first);
      if (!good[lane]) {
        results[i] = unloaded_stiffness_matrix(manipulator, postures[i]);
        continue;
      }
      Matrix6 matrix;
      for (int row = 0; row < 6; ++row)
        for (int column = 0; column <= row; ++column)
          matrix(row, column) = matrix(column, row) = sum(row, column)[lane];
      results[i].emplace(matrix, spatial::Frame{postures[i].platform.position()});
    }
  }
  return results;
}

}  // namespace kinetostat::vjm
