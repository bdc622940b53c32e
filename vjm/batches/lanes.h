// Numbers side by side in the vector registers of the processor: the same work on several poses.
#pragma once

#include <algorithm>
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
