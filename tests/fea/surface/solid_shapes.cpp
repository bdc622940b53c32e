#include "fea/surface/solid_shapes.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace kinetostat::fea::hard {
namespace {

double cross(const Point2& a, const Point2& b, const Point2& c) {
  return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

bool crosses(const Point2& a, const Point2& b, const Point2& c, const Point2& d) {
  return cross(a, b, c) * cross(a, b, d) < 0 && cross(c, d, a) * cross(c, d, b) < 0;
}

// One loop of indices: each hole joined to the loop by the shortest bridge that crosses nothing.
std::vector<int> bridged(const std::vector<Point2>& points, std::vector<std::vector<int>> loops) {
  std::vector<int> whole = loops.front();
  std::vector<bool> done(loops.size(), false);
  done[0] = true;
  const auto at = [&](int i) { return points[static_cast<std::size_t>(i)]; };
  const auto is_free = [&](int p, int q) {
    for (const auto& loop : loops)
      for (std::size_t i = 0; i < loop.size(); ++i)
        if (crosses(at(p), at(q), at(loop[i]), at(loop[(i + 1) % loop.size()]))) return false;
    return true;
  };
  for (std::size_t round = 1; round < loops.size(); ++round) {
    double best = 1e300;
    std::size_t from = 0, hole = 0, to = 0;
    for (std::size_t h = 1; h < loops.size(); ++h)
      for (std::size_t i = 0; !done[h] && i < loops[h].size(); ++i)
        for (std::size_t j = 0; j < whole.size(); ++j) {
          const double length = (at(loops[h][i]) - at(whole[j])).norm();
          if (length >= best || !is_free(loops[h][i], whole[j])) continue;
          best = length, from = j, hole = h, to = i;
        }
    std::vector<int> joined(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(from) + 1);
    for (std::size_t i = 0; i <= loops[hole].size(); ++i)
      joined.push_back(loops[hole][(to + i) % loops[hole].size()]);
    joined.insert(joined.end(), whole.begin() + static_cast<std::ptrdiff_t>(from), whole.end());
    whole = std::move(joined);
    done[hole] = true;
  }
  return whole;
}

// Ears, the roundest first.
std::vector<Triangle> ears(const std::vector<Point2>& points, std::vector<int> loop) {
  const auto at = [&](int i) -> const Point2& { return points[static_cast<std::size_t>(i)]; };
  const auto roundness = [&](std::size_t i) {
    const std::size_t n = loop.size();
    const int p = loop[(i + n - 1) % n], q = loop[i], r = loop[(i + 1) % n];
    const double area = cross(at(p), at(q), at(r));
    if (area <= 0) return -1.0;
    for (const int other : loop) {
      if (at(other) == at(p) || at(other) == at(q) || at(other) == at(r)) continue;
      if (cross(at(p), at(q), at(other)) >= 0 && cross(at(q), at(r), at(other)) >= 0 &&
          cross(at(r), at(p), at(other)) >= 0)
        return -1.0;
    }
    const double longest =
        std::max({(at(q) - at(p)).norm(), (at(r) - at(q)).norm(), (at(p) - at(r)).norm()});
    return area / (longest * longest);
  };
  std::vector<Triangle> triangles;
  while (loop.size() > 3) {
    double best = 0;
    std::size_t ear = loop.size();
    for (std::size_t i = 0; i < loop.size() && best < 0.3; ++i)
      if (const double value = roundness(i); value > best) best = value, ear = i;
    if (ear == loop.size()) throw std::logic_error("an outline without an ear");
    const std::size_t n = loop.size();
    triangles.push_back({loop[(ear + n - 1) % n], loop[ear], loop[(ear + 1) % n]});
    loop.erase(loop.begin() + static_cast<std::ptrdiff_t>(ear));
  }
  triangles.push_back({loop[0], loop[1], loop[2]});
  return triangles;
}

double signed_volume(const SurfaceMesh& mesh) {
  double volume = 0;
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f)
    volume += mesh.area_vector(f).dot(mesh.centroid(f)) / 3;
  return volume;
}

void add_quad(SurfaceMesh& mesh, int a, int b, int c, int d) {
  mesh.triangles.push_back({a, b, c});
  mesh.triangles.push_back({a, c, d});
}

}  // namespace

Outline circle(const Point2& centre, double radius, int sides) {
  Outline outline;
  for (int i = 0; i < sides; ++i) {
    const double angle = 2 * M_PI * i / sides;
    outline.push_back(centre + radius * Point2(std::cos(angle), std::sin(angle)));
  }
  return outline;
}

Outline rounded_rectangle(const Point2& low, const Point2& high, double radius, int segments) {
  const Point2 inner_low = low.array() + radius, inner_high = high.array() - radius;
  const Point2 corners[4] = {{inner_high.x(), inner_high.y()},
                             {inner_low.x(), inner_high.y()},
                             {inner_low.x(), inner_low.y()},
                             {inner_high.x(), inner_low.y()}};
  Outline outline;
  for (int quarter = 0; quarter < 4; ++quarter)
    for (int i = 0; i <= segments; ++i) {
      const double angle = M_PI / 2 * (quarter + static_cast<double>(i) / segments);
      outline.push_back(corners[quarter] + radius * Point2(std::cos(angle), std::sin(angle)));
    }
  return outline;
}

Outline strip(const std::vector<Point2>& middle, double width) {
  Outline left, right;
  for (std::size_t i = 0; i < middle.size(); ++i) {
    const Point2 in = i > 0 ? Point2((middle[i] - middle[i - 1]).normalized()) : Point2(0, 0);
    const Point2 out =
        i + 1 < middle.size() ? Point2((middle[i + 1] - middle[i]).normalized()) : Point2(0, 0);
    const Point2 along = (in + out).normalized();
    const double reach = i > 0 && i + 1 < middle.size() ? along.dot(in) : 1;  // mitred
    const Point2 side = Point2(-along.y(), along.x()) * (width / 2 / reach);
    left.push_back(middle[i] + side);
    right.push_back(middle[i] - side);
  }
  right.insert(right.end(), left.rbegin(), left.rend());
  return right;
}

SurfaceMesh prism(const Outline& outline, const std::vector<Outline>& holes, double height,
                  int layers) {
  std::vector<Point2> points;
  std::vector<std::vector<int>> loops;
  const auto add_loop = [&](const Outline& loop, bool is_hole) {
    loops.emplace_back();
    for (const Point2& p : loop) {
      loops.back().push_back(static_cast<int>(points.size()));
      points.push_back(p);
    }
    if (is_hole) std::reverse(loops.back().begin(), loops.back().end());
  };
  add_loop(outline, false);
  for (const Outline& hole : holes) add_loop(hole, true);
  const int n = static_cast<int>(points.size());
  SurfaceMesh mesh;
  for (int layer = 0; layer <= layers; ++layer)
    for (const Point2& p : points) mesh.points.emplace_back(p.x(), p.y(), height * layer / layers);
  const int top = n * layers;
  for (const Triangle& t : ears(points, bridged(points, loops))) {
    mesh.triangles.push_back({t[0] + top, t[1] + top, t[2] + top});
    mesh.triangles.push_back({t[0], t[2], t[1]});
  }
  for (const auto& loop : loops)
    for (std::size_t i = 0; i < loop.size(); ++i)
      for (int layer = 0; layer < layers; ++layer) {
        const int a = loop[i] + n * layer, b = loop[(i + 1) % loop.size()] + n * layer;
        add_quad(mesh, a, b, b + n, a + n);
      }
  return mesh;
}

SurfaceMesh revolved(const Outline& profile, int sides) {
  SurfaceMesh mesh;
  std::vector<int> first;
  std::vector<bool> on_axis;
  for (const Point2& p : profile) {
    first.push_back(static_cast<int>(mesh.points.size()));
    on_axis.push_back(p.y() == 0);
    for (int i = 0; i < (p.y() == 0 ? 1 : sides); ++i) {
      const double angle = 2 * M_PI * i / sides;
      mesh.points.emplace_back(p.x(), p.y() * std::cos(angle), p.y() * std::sin(angle));
    }
  }
  for (std::size_t k = 0; k < profile.size(); ++k) {
    const std::size_t l = (k + 1) % profile.size();
    if (on_axis[k] && on_axis[l]) continue;
    for (int i = 0; i < sides; ++i) {
      const auto corner = [&](std::size_t ring, int j) {
        return first[ring] + (on_axis[ring] ? 0 : j % sides);
      };
      const int a = corner(k, i), b = corner(k, i + 1), c = corner(l, i), d = corner(l, i + 1);
      if (a != b) mesh.triangles.push_back({a, c, b});
      if (c != d) mesh.triangles.push_back({b, c, d});
    }
  }
  return signed_volume(mesh) < 0 ? inverted(std::move(mesh)) : mesh;
}

SurfaceMesh lofted_shell(const Ring& outer, const Ring& inner, int around, int along) {
  SurfaceMesh mesh;
  for (int layer = 0; layer < 2; ++layer)
    for (int s = 0; s <= along; ++s)
      for (int i = 0; i < around; ++i)
        mesh.points.push_back(
            (layer == 0 ? outer : inner)(static_cast<double>(s) / along, 2 * M_PI * i / around));
  const auto number = [&](int layer, int s, int i) {
    return (layer * (along + 1) + s) * around + i % around;
  };
  for (int i = 0; i < around; ++i) {
    for (int s = 0; s < along; ++s) {
      add_quad(mesh, number(0, s, i), number(0, s + 1, i), number(0, s + 1, i + 1),
               number(0, s, i + 1));
      add_quad(mesh, number(1, s, i), number(1, s, i + 1), number(1, s + 1, i + 1),
               number(1, s + 1, i));
    }
    add_quad(mesh, number(0, 0, i), number(0, 0, i + 1), number(1, 0, i + 1), number(1, 0, i));
    add_quad(mesh, number(0, along, i), number(1, along, i), number(1, along, i + 1),
             number(0, along, i + 1));
  }
  return signed_volume(mesh) < 0 ? inverted(std::move(mesh)) : mesh;
}

SurfaceMesh cells(const std::vector<double>& x, const std::vector<double>& y,
                  const std::vector<double>& z,
                  const std::function<bool(const Vector3&)>& is_full) {
  const std::vector<double>* lines[3] = {&x, &y, &z};
  const int n[3] = {static_cast<int>(x.size()) - 1, static_cast<int>(y.size()) - 1,
                    static_cast<int>(z.size()) - 1};
  const auto full = [&](const std::array<int, 3>& c) {
    Vector3 middle;
    for (int k = 0; k < 3; ++k) {
      const auto i = static_cast<std::size_t>(c[static_cast<std::size_t>(k)]);
      if (c[static_cast<std::size_t>(k)] < 0 || c[static_cast<std::size_t>(k)] >= n[k])
        return false;
      middle[k] = 0.5 * ((*lines[k])[i] + (*lines[k])[i + 1]);
    }
    return is_full(middle);
  };
  SurfaceMesh mesh;
  for (const double c : z)
    for (const double b : y)
      for (const double a : x) mesh.points.emplace_back(a, b, c);
  const auto number = [&](const std::array<int, 3>& p) {
    return p[0] + (n[0] + 1) * (p[1] + (n[1] + 1) * p[2]);
  };
  std::array<int, 3> c{};
  for (c[2] = 0; c[2] < n[2]; ++c[2])
    for (c[1] = 0; c[1] < n[1]; ++c[1])
      for (c[0] = 0; c[0] < n[0]; ++c[0]) {
        if (!full(c)) continue;
        for (std::size_t k = 0; k < 3; ++k)
          for (const int side : {0, 1}) {
            std::array<int, 3> beyond = c;
            beyond[k] += side == 0 ? -1 : 1;
            if (full(beyond)) continue;
            std::array<int, 3> p = c;
            p[k] += side;
            std::array<int, 3> q = p, r = p, s = p;
            ++q[(k + 1) % 3], ++r[(k + 1) % 3], ++r[(k + 2) % 3], ++s[(k + 2) % 3];
            if (side == 1)
              add_quad(mesh, number(p), number(q), number(r), number(s));
            else
              add_quad(mesh, number(p), number(s), number(r), number(q));
          }
      }
  drop_unused_points(mesh);
  return mesh;
}

SurfaceMesh union_of(const std::vector<Box>& boxes) {
  std::array<std::set<double>, 3> lines;
  for (const Box& box : boxes)
    for (std::size_t k = 0; k < 3; ++k)
      lines[k].insert(
          {box.min()[static_cast<Eigen::Index>(k)], box.max()[static_cast<Eigen::Index>(k)]});
  const auto list = [&](std::size_t k) {
    return std::vector<double>(lines[k].begin(), lines[k].end());
  };
  return cells(list(0), list(1), list(2), [&](const Vector3& p) {
    return std::any_of(boxes.begin(), boxes.end(), [&](const Box& b) { return b.contains(p); });
  });
}

SurfaceMesh icosahedron(const Vector3& centre, double radius) {
  const double g = (1 + std::sqrt(5.0)) / 2, scale = radius / std::sqrt(1 + g * g);
  SurfaceMesh mesh;
  for (int k = 0; k < 3; ++k)
    for (const double a : {-1.0, 1.0})
      for (const double b : {-g, g}) {
        Vector3 p = Vector3::Zero();
        p[k] = a, p[(k + 1) % 3] = b;
        mesh.points.push_back(centre + scale * p);
      }
  for (int a = 0; a < 12; ++a)
    for (int b = a + 1; b < 12; ++b)
      for (int c = b + 1; c < 12; ++c) {
        const auto p = [&](int i) -> const Vector3& {
          return mesh.points[static_cast<std::size_t>(i)];
        };
        const double most = 2.1 * scale;
        if ((p(a) - p(b)).norm() > most || (p(b) - p(c)).norm() > most ||
            (p(c) - p(a)).norm() > most)
          continue;
        const bool outward = (p(b) - p(a)).cross(p(c) - p(a)).dot(p(a) - centre) > 0;
        mesh.triangles.push_back(outward ? Triangle{a, b, c} : Triangle{a, c, b});
      }
  return mesh;
}

SurfaceMesh turned(SurfaceMesh mesh) {
  for (Vector3& p : mesh.points) p = Vector3(p.y(), p.z(), p.x());
  return mesh;
}

}  // namespace kinetostat::fea::hard
