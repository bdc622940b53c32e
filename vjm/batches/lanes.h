// Numbers side by side in the vector registers of the processor: the same work on several poses.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>

#include <Eigen/Core>

namespace kinetostat::vjm {

inline constexpr int lane_count = 4;

/// Yes or no in every lane.
class alignas(lane_count * sizeof(long long)) LaneMask {
 public:
  using Vector = long long __attribute__((vector_size(lane_count * sizeof(long long))));

  LaneMask() = default;
  explicit LaneMask(Vector value) : value_(value) {}
  static LaneMask all() { return LaneMask(Vector{-1, -1, -1, -1}); }

  bool operator[](int lane) const { return value_[lane] != 0; }
  bool any() const { return (value_[0] | value_[1] | value_[2] | value_[3]) != 0; }
  LaneMask operator&(LaneMask other) const { return LaneMask(value_ & other.value_); }
  LaneMask operator|(LaneMask other) const { return LaneMask(value_ | other.value_); }
  LaneMask operator!() const { return LaneMask(~value_); }
  const Vector& vector() const { return value_; }

 private:
  Vector value_{};
};

/// A number in every lane, a scalar for Eigen's matrices of fixed size. No lane knows of the
/// others: each holds what a double would, to the last bit, whatever the processor offers. Aligned
/// for the widest registers, which the compiler does not know of where it makes room for one.
class alignas(lane_count * sizeof(double)) Lanes {
 public:
  using Vector = double __attribute__((vector_size(lane_count * sizeof(double))));

  /// No number yet, as of a double: lanes are filled where they are made.
  Lanes() {}  // NOLINT(modernize-use-equals-default,cppcoreguidelines-pro-type-member-init)
  Lanes(double all) : value_{all, all, all, all} {}
  explicit Lanes(Vector value) : value_(value) {}

  double operator[](int lane) const { return value_[lane]; }
  void set(int lane, double value) { value_[lane] = value; }

  Lanes operator-() const { return Lanes(-value_); }
  Lanes& operator+=(Lanes b) { return *this = *this + b; }
  Lanes& operator-=(Lanes b) { return *this = *this - b; }
  Lanes& operator*=(Lanes b) { return *this = *this * b; }
  Lanes& operator/=(Lanes b) { return *this = *this / b; }
  friend Lanes operator+(Lanes a, Lanes b) { return Lanes(a.value_ + b.value_); }
  friend Lanes operator-(Lanes a, Lanes b) { return Lanes(a.value_ - b.value_); }
  friend Lanes operator*(Lanes a, Lanes b) { return Lanes(a.value_ * b.value_); }
  friend Lanes operator/(Lanes a, Lanes b) { return Lanes(a.value_ / b.value_); }
  friend LaneMask operator<(Lanes a, Lanes b) { return LaneMask(a.value_ < b.value_); }
  friend LaneMask operator<=(Lanes a, Lanes b) { return LaneMask(a.value_ <= b.value_); }
  friend LaneMask operator>(Lanes a, Lanes b) { return LaneMask(a.value_ > b.value_); }

  /// `yes` where the mask says so, `no` elsewhere.
  static Lanes chosen(LaneMask mask, Lanes yes, Lanes no) {
    return Lanes(mask.vector() ? yes.value_ : no.value_);
  }
  friend Lanes max(Lanes a, Lanes b) { return chosen(a > b, a, b); }
  friend Lanes min(Lanes a, Lanes b) { return chosen(a < b, a, b); }
  friend Lanes abs(Lanes a) { return max(a, -a); }
  const Vector& vector() const { return value_; }

 private:
  Vector value_;
};

/// A function of one number, lane by lane.
template <class Function>
inline Lanes lane_by_lane(Lanes a, const Function& function) {
  Lanes result;
  for (int lane = 0; lane < lane_count; ++lane) result.set(lane, function(a[lane]));
  return result;
}
inline Lanes sqrt(Lanes a) {
  return lane_by_lane(a, [](double x) { return std::sqrt(x); });
}

/// The highest power first.
template <std::size_t count>
inline Lanes polynomial(Lanes x, const double (&coefficients)[count]) {
  Lanes sum(coefficients[0]);
  for (std::size_t i = 1; i < count; ++i) sum = sum * x + coefficients[i];
  return sum;
}

/// Of angles of at most an eighth of a turn, to a unit of the last digit: the polynomials of the
/// Cephes library (Moshier 1989).
inline Lanes sine_of_small(Lanes x) {
  const Lanes z = x * x;
  return x + x * z *
                 polynomial(z, {1.58962301576546568060e-10, -2.50507477628578072866e-8,
                                2.75573136213857245213e-6, -1.98412698295895385996e-4,
                                8.33333333332211858878e-3, -1.66666666666666307295e-1});
}
inline Lanes cosine_of_small(Lanes x) {
  const Lanes z = x * x;
  return 1.0 - 0.5 * z +
         z * z *
             polynomial(z, {-1.13585365213876817300e-11, 2.08757008419747316778e-9,
                            -2.75573141792967388112e-7, 2.48015872888517045348e-5,
                            -1.38888888888730564116e-3, 4.16666666666665929218e-2});
}

/// Sine and cosine, to two units of the last digit of 1. Quarter turns are taken off in three
/// pieces, so that what is left is exact (Cody and Waite 1980).
inline void sine_and_cosine(Lanes angle, Lanes& sine, Lanes& cosine) {
  constexpr double per_radian = 0.63661977236758134308, to_whole = 0x1.8p52;
  constexpr double quarter[3] = {1.57079625129699707031, 7.54978941586159635335e-8,
                                 5.39030285815811905290e-15};
  const Lanes shifted = angle * per_radian + to_whole, quarters = shifted - to_whole;
  const Lanes left = angle - quarters * quarter[0] - quarters * quarter[1] - quarters * quarter[2];
  const auto count = std::bit_cast<LaneMask::Vector>(shifted.vector());  // in its last two digits
  const LaneMask is_odd(-(count & 1));
  const Lanes s = sine_of_small(left), c = cosine_of_small(left);
  const auto turned = [](Lanes value, LaneMask::Vector halves) {
    const auto digits = std::bit_cast<LaneMask::Vector>(value.vector());
    return Lanes(std::bit_cast<Lanes::Vector>(digits ^ ((halves & 2) << 62)));
  };
  sine = turned(Lanes::chosen(is_odd, c, s), count);
  cosine = turned(Lanes::chosen(is_odd, s, c), count + 1);
  const LaneMask is_far = abs(angle) > 1e6;  // where the pieces are no longer exact
  for (int lane = 0; is_far.any() && lane < lane_count; ++lane) {
    if (!is_far[lane]) continue;
    sine.set(lane, std::sin(angle[lane]));
    cosine.set(lane, std::cos(angle[lane]));
  }
}

/// A matrix of lanes. They know their own alignment, which is more than Eigen may know of.
template <int rows, int columns, int most_rows = rows, int most_columns = columns>
using LaneMatrix = Eigen::Matrix<Lanes, rows, columns, Eigen::DontAlign, most_rows, most_columns>;
using Vector3Lanes = LaneMatrix<3, 1>;
using Vector6Lanes = LaneMatrix<6, 1>;
using Matrix3Lanes = LaneMatrix<3, 3>;
using Matrix6Lanes = LaneMatrix<6, 6>;

/// Which of `count` pieces of work a lane takes in the group that starts at `first`; the last one
/// fills lanes that are left.
inline std::size_t piece_of(std::size_t first, int lane, std::size_t count) {
  return std::min(first + static_cast<std::size_t>(lane), count - 1);
}

/// Does work(), which returns nothing, with the widest registers that the processor has: all that
/// it calls is compiled into one piece for each kind.
template <class Work>
[[gnu::flatten]] void in_narrow_lanes(const Work& work) {
  work();
}
#if defined(__x86_64__)
template <class Work>
[[gnu::flatten, gnu::target("avx2")]] void in_wide_lanes(const Work& work) {
  work();
}
template <class Work>
void in_lanes(const Work& work) {
  static const bool wide = __builtin_cpu_supports("avx2") != 0;
  wide ? in_wide_lanes(work) : in_narrow_lanes(work);
}
#else
template <class Work>
void in_lanes(const Work& work) {
  in_narrow_lanes(work);
}
#endif

}  // namespace kinetostat::vjm

namespace Eigen {
template <>
struct NumTraits<kinetostat::vjm::Lanes> : GenericNumTraits<kinetostat::vjm::Lanes> {
  using Real = kinetostat::vjm::Lanes;
  using NonInteger = kinetostat::vjm::Lanes;
  using Nested = kinetostat::vjm::Lanes;
  enum {
    IsComplex = 0,
    IsInteger = 0,
    IsSigned = 1,
    RequireInitialization = 0,
    ReadCost = 1,
    AddCost = 1,
    MulCost = 1
  };
};
}  // namespace Eigen
