// Frames that are led along the joints of a chain, in every lane its own. Internal to this module.
#pragma once

#include "kinetostat/spatial/linear_algebra.h"
#include "kinetostat/vjm/batches/lanes.h"

namespace kinetostat::vjm {

inline Vector3Lanes cross(const Vector3Lanes& a, const Vector3Lanes& b) {
  Vector3Lanes product;
  for (int i = 0; i < 3; ++i)
    product[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
  return product;
}
inline Lanes dot(const Vector3Lanes& a, const Vector3Lanes& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// The frame that stands at `rotation` and `position`, the same in all lanes, in another one.
inline void lead(const Matrix3Lanes& from, const Vector3Lanes& origin,
                 const spatial::Matrix3& rotation, const spatial::Vector3& position,
                 Matrix3Lanes& r, Vector3Lanes& p) {
  for (int i = 0; i < 3; ++i) {
    Lanes sum = origin[i];
    for (int k = 0; k < 3; ++k) sum += from(i, k) * position[k];
    p[i] = sum;
    for (int j = 0; j < 3; ++j)
      r(i, j) =
          from(i, 0) * rotation(0, j) + from(i, 1) * rotation(1, j) + from(i, 2) * rotation(2, j);
  }
}

/// Turns a frame about an axis of its own, 0 to 2: only the two other columns change.
inline void turn(int axis, Lanes angle, Matrix3Lanes& r) {
  Lanes s, c;
  sine_and_cosine(angle, s, c);
  const int a = (axis + 1) % 3, b = (axis + 2) % 3;
  for (int i = 0; i < 3; ++i) {
    const Lanes u = r(i, a), v = r(i, b);
    r(i, a) = c * u + s * v;
    r(i, b) = c * v - s * u;
  }
}

}  // namespace kinetostat::vjm
