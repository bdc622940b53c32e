#include "kinetostat/fea/interface/interface_selection.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <type_traits>

#include <Eigen/Eigenvalues>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/common/index.h"
#include "kinetostat/common/spelling.h"
#include "kinetostat/fea/interface/face_integral.h"
#include "kinetostat/fea/surface/box_tree.h"
#include "kinetostat/fea/surface/surface_faces.h"
#include "kinetostat/spatial/units.h"

namespace kinetostat::fea {
namespace {

using common::at;

constexpr double degree = std::numbers::pi / 180;
constexpr std::size_t shown = 4;  // candidates in a message

double distance_tolerance(const SurfaceMesh& surface) {
  return 1e-4 * bounding_box(surface.points).diagonal().norm();
}

double distance_from_axis(const Vector3& p, const Vector3& axis_point, const Vector3& axis) {
  const Vector3 arm = p - axis_point;
  return (arm - axis * axis.dot(arm)).norm();
}

// Distance of a point from a triangle: from its plane when it lies above or below, else from the
// nearest side.
double distance_from_triangle(const Vector3& p, const std::array<Vector3, 3>& t) {
  const Vector3 normal = (t[1] - t[0]).cross(t[2] - t[0]).normalized();
  bool inside = true;
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < 3; ++k) {
    const Vector3 side = t[(k + 1) % 3] - t[k], arm = p - t[k];
    inside = inside && normal.dot(side.cross(arm)) >= 0;
    const double along = std::clamp(side.dot(arm) / side.squaredNorm(), 0.0, 1.0);
    nearest = std::min(nearest, (arm - along * side).norm());
  }
  return inside ? std::abs(normal.dot(p - t[0])) : nearest;
}

// Whether points lie on a surface.
class PatchMatcher {
 public:
  PatchMatcher(const SurfaceMesh& surface, double tolerance)
      : surface_(surface), tolerance_(tolerance), tree_(facet_boxes(surface, tolerance)) {}

  bool contains(const Vector3& p) const {
    bool found = false;
    tree_.visit_overlapping(Box(p, p), [&](int facet) {
      const auto f = at(facet);
      found = found || distance_from_triangle(p, {surface_.corner(f, 0), surface_.corner(f, 1),
                                                  surface_.corner(f, 2)}) <= tolerance_;
    });
    return found;
  }

 private:
  const SurfaceMesh& surface_;
  double tolerance_;
  BoxTree tree_;
};

// One test a kind of selector: does this facet belong?
class Membership {
 public:
  explicit Membership(const SurfaceMesh& surface)
      : surface_(surface), tolerance_(distance_tolerance(surface)) {}

  bool operator()(const PlaneSelector& plane, std::size_t f) const {
    const Vector3 area = surface_.area_vector(f);
    return every_corner(f,
                        [&](const Vector3& p) {
                          return std::abs(plane.normal.dot(p - plane.point)) <= tolerance_;
                        }) &&
           area.dot(plane.normal) >= std::cos(degree) * area.norm();
  }

  bool operator()(const CylinderSelector& cylinder, std::size_t f) const {
    const double slack = std::max(tolerance_, 0.01 * cylinder.radius);
    const bool on_radius = every_corner(f, [&](const Vector3& p) {
      const double along = cylinder.axis.dot(p - cylinder.axis_point);
      return std::abs(distance_from_axis(p, cylinder.axis_point, cylinder.axis) -
                      cylinder.radius) <= slack &&
             (!cylinder.length || (along >= -tolerance_ && along <= *cylinder.length + tolerance_));
    });
    if (!on_radius) return false;
    // Not an annulus at the end (slanting triangles of a coarse cylinder lean a few degrees), nor a
    // flat cut through the cylinder: fewer than eight facets around are not a cylinder.
    const Vector3 normal = surface_.area_vector(f).normalized();
    return std::abs(normal.dot(cylinder.axis)) < std::sin(30 * degree) &&
           distance_from_axis(surface_.centroid(f), cylinder.axis_point, cylinder.axis) >
               std::cos(180 * degree / 8) * cylinder.radius - slack;
  }

  bool operator()(const SphereSelector& sphere, std::size_t f) const {
    const double slack = std::max(tolerance_, 0.01 * sphere.radius);
    if (!every_corner(f, [&](const Vector3& p) {
          return std::abs((p - sphere.center).norm() - sphere.radius) <= slack;
        }))
      return false;
    // Not a flat cut through the ball, nor a face that has only its corners in common with it.
    const Vector3 radial = surface_.centroid(f) - sphere.center;
    return radial.norm() > std::cos(180 * degree / 8) * sphere.radius - slack &&
           std::abs(surface_.area_vector(f).normalized().dot(radial.normalized())) >
               std::cos(30 * degree);
  }

  bool operator()(const BoxSelector& selector, std::size_t f) const {
    Box grown = selector.box;
    grown.min().array() -= tolerance_;
    grown.max().array() += tolerance_;
    return every_corner(f, [&grown](const Vector3& p) { return grown.contains(p); });
  }

 private:
  template <class Test>
  bool every_corner(std::size_t f, Test test) const {
    return test(surface_.corner(f, 0)) && test(surface_.corner(f, 1)) &&
           test(surface_.corner(f, 2));
  }

  const SurfaceMesh& surface_;
  double tolerance_;
};

// The facet first met by the ray, or -1. Sides count as inside, so that no ray passes between
// facets.
double distance_along(const NearestFaceSelector& ray, const SurfaceMesh& surface, std::size_t f) {
  constexpr double missed = std::numeric_limits<double>::infinity();
  const Vector3 &a = surface.corner(f, 0), ab = surface.corner(f, 1) - a,
                ac = surface.corner(f, 2) - a, cross = ray.direction.cross(ac);
  const double determinant = ab.dot(cross);
  if (determinant == 0) return missed;
  const Vector3 arm = ray.point - a;
  const double u = arm.dot(cross) / determinant;
  const double v = ray.direction.dot(arm.cross(ab)) / determinant;
  const double distance = ac.dot(arm.cross(ab)) / determinant;
  constexpr double edge = -1e-9;
  if (u < edge || v < edge || u + v > 1 - edge || distance < -distance_tolerance(surface))
    return missed;
  return distance;
}

int first_hit(const SurfaceMesh& surface, const NearestFaceSelector& ray) {
  int nearest = -1;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t f = 0; f < surface.triangles.size(); ++f) {
    const double distance = distance_along(ray, surface, f);
    if (!(distance < least)) continue;
    least = distance;
    nearest = static_cast<int>(f);
  }
  return nearest;
}

std::vector<int> flat_face_of(const SurfaceMesh& surface, int facet) {
  for (const FlatFace& face : flat_faces(surface, weld_tolerance(surface.points)))
    if (std::binary_search(face.facets.begin(), face.facets.end(), facet)) return face.facets;
  return {};
}

template <class Chosen>
std::vector<int> facets_where(const SurfaceMesh& surface, Chosen chosen) {
  std::vector<int> facets;
  for (std::size_t f = 0; f < surface.triangles.size(); ++f)
    if (chosen(f)) facets.push_back(static_cast<int>(f));
  return facets;
}

std::vector<int> group(const SurfaceMesh& surface, const GroupSelector& selector) {
  for (const FacetGroup& group : surface.groups)
    if (group.name == selector.name) return group.facets;
  return {};
}

// Facets of the faces of the CAD file that are chosen by number (from 1) and face.
template <class Chosen>
std::vector<int> of_cad_faces(const SurfaceMesh& surface, Chosen chosen) {
  const std::vector<int> face = face_of_facets(surface);
  return facets_where(surface, [&](std::size_t f) {
    return face[f] > 0 && chosen(face[f], surface.faces[at(face[f] - 1)]);
  });
}

std::vector<int> of_cad_face(const SurfaceMesh& surface, const CadFaceSelector& selector) {
  return of_cad_faces(surface, [&](int number, const CadFace& face) {
    return selector.number > 0 ? number == selector.number : face.name == selector.name;
  });
}

std::vector<int> of_colour(const SurfaceMesh& surface, const ColourSelector& selector) {
  return of_cad_faces(surface,
                      [&](int, const CadFace& face) { return face.colour == selector.colour; });
}

std::vector<int> on_patch(const SurfaceMesh& surface, const PatchSelector& selector) {
  const PatchMatcher patch(selector.patch, distance_tolerance(surface));
  return facets_where(surface, [&](std::size_t f) {
    return patch.contains(surface.corner(f, 0)) && patch.contains(surface.corner(f, 1)) &&
           patch.contains(surface.corner(f, 2)) && patch.contains(surface.centroid(f));
  });
}

std::string text(const Vector3& v) {
  // Adding zero turns -0 into 0; rounding hides the noise of a normalised direction.
  const auto clean = [](double x) { return std::abs(x) < 5e-7 ? 0.0 : x; };
  return fmt::format("[{:.5g}, {:.5g}, {:.5g}]", clean(v.x()), clean(v.y()), clean(v.z()));
}

// Candidates with a figure for how far they are from what was asked for.
struct Candidate {
  double distance;
  std::string text;
};

std::string nearest_of(std::vector<Candidate> candidates, const char* kind) {
  if (candidates.empty()) return fmt::format("The surface has no {}", kind);
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.distance < b.distance; });
  std::vector<std::string> texts;
  for (std::size_t i = 0; i < std::min(shown, candidates.size()); ++i)
    texts.push_back(candidates[i].text);
  return fmt::format("The nearest {}: {}", kind, fmt::join(texts, "; "));
}

class Suggestion {
 public:
  Suggestion(const SurfaceMesh& surface, const std::string& unit)
      : surface_(surface),
        unit_(unit),
        length_(spatial::parse_quantity("1 " + unit, spatial::dimension::length)) {}

  std::string operator()(const PlaneSelector& plane) const {
    const double size = bounding_box(surface_.points).diagonal().norm();
    return flat_candidates([&](const FlatFace& face) {
      // A sign error of the normal is a smaller mistake than a wrong direction.
      const double cosine = plane.normal.dot(face.normal);
      return std::abs(plane.normal.dot(face.centroid - plane.point)) / size +
             (1 - std::abs(cosine)) + 0.05 * (1 - cosine);
    });
  }

  std::string operator()(const CylinderSelector& cylinder) const {
    std::vector<Candidate> list;
    for (const RoundFace& face :
         round_faces(surface_, flat_faces(surface_, weld_tolerance(surface_.points)))) {
      const double off_axis =
          distance_from_axis(face.axis_point, cylinder.axis_point, cylinder.axis);
      const double turn = 1 - std::abs(face.axis.dot(cylinder.axis));
      list.push_back({off_axis + std::abs(face.radius - cylinder.radius) + turn * face.radius,
                      fmt::format("radius {:.5g} {} about axis {} through {}, length {:.5g}",
                                  face.radius / length_, unit_, text(face.axis),
                                  text(face.axis_point / length_), face.length / length_)});
    }
    return nearest_of(std::move(list), "cylinders");
  }

  std::string operator()(const BoxSelector&) const {
    const Box box = bounding_box(surface_.points);
    return fmt::format("The mesh reaches from {} to {} {}", text(box.min() / length_),
                       text(box.max() / length_), unit_);
  }

  std::string operator()(const SphereSelector& sphere) const {
    double nearest = std::numeric_limits<double>::infinity();
    for (const Vector3& p : surface_.points)
      if (const double d = (p - sphere.center).norm();
          std::abs(d - sphere.radius) < std::abs(nearest - sphere.radius))
        nearest = d;
    return fmt::format(
        "The surface is not round about this centre; the corner nearest to the radius is {:.5g} {} "
        "away from it",
        nearest / length_, unit_);
  }

  std::string operator()(const GroupSelector& wanted) const {
    std::vector<std::string> names;
    for (const FacetGroup& group : surface_.groups) names.push_back(group.name);
    if (names.empty()) return "The mesh file names no groups of facets";
    const std::string near = common::nearest_spelling(wanted.name, names);
    return (near.empty() ? "" : fmt::format("Did you mean '{}'? ", near)) +
           fmt::format("Groups of the mesh: {}", fmt::join(names, ", "));
  }

  std::string operator()(const CadFaceSelector& wanted) const {
    if (surface_.faces.empty()) return no_cad_faces();
    const std::string all = fmt::format("The faces are 1 to {}", surface_.faces.size());
    const std::vector<std::string> names = texts_of_faces(&CadFace::name);
    if (wanted.number > 0 || names.empty())
      return all + (names.empty() ? ", none has a name" : "") + list_of_faces;
    const std::string near = common::nearest_spelling(wanted.name, names);
    return fmt::format("{}{}{}", near.empty() ? "" : fmt::format("Did you mean '{}'? ", near), all,
                       list_of_faces);
  }

  std::string operator()(const ColourSelector&) const {
    if (surface_.faces.empty()) return no_cad_faces();
    const std::vector<std::string> colours = texts_of_faces(&CadFace::colour);
    if (colours.empty()) return "No face of the file has a colour";
    return fmt::format("The colours of its faces: {}{}", fmt::join(colours, ", "), list_of_faces);
  }

  std::string operator()(const PatchSelector& given) const {
    const Box box = bounding_box(surface_.points), patch = bounding_box(given.patch.points);
    return fmt::format(
        "The mesh reaches from {} to {} {}, the patch from {} to {}: is it in the same unit and "
        "place, and as fine on round faces?",
        text(box.min() / length_), text(box.max() / length_), unit_, text(patch.min() / length_),
        text(patch.max() / length_));
  }

  std::string operator()(const NearestFaceSelector& ray) const {
    return flat_candidates([&](const FlatFace& face) {
      const Vector3 arm = face.centroid - ray.point;
      return arm.norm() - ray.direction.dot(arm);
    });
  }

 private:
  static constexpr const char* list_of_faces = "; 'kinetostat mesh check --faces' lists them";
  static std::string no_cad_faces() {
    return "Only STEP files have faces with numbers, names and colours";
  }

  // Of all faces, without empty ones, each once.
  std::vector<std::string> texts_of_faces(std::string CadFace::*text) const {
    std::vector<std::string> texts;
    for (const CadFace& face : surface_.faces)
      if (!(face.*text).empty()) texts.push_back(face.*text);
    std::sort(texts.begin(), texts.end());
    texts.erase(std::unique(texts.begin(), texts.end()), texts.end());
    return texts;
  }

  template <class Distance>
  std::string flat_candidates(Distance distance) const {
    std::vector<Candidate> list;
    for (const FlatFace& face : flat_faces(surface_, weld_tolerance(surface_.points)))
      list.push_back(
          {distance(face),
           fmt::format("point {} {}, normal {}, area {:.4g} {}^2", text(face.centroid / length_),
                       unit_, text(face.normal), face.area / (length_ * length_), unit_)});
    return nearest_of(std::move(list), "flat faces");
  }

  const SurfaceMesh& surface_;
  const std::string& unit_;
  double length_;
};

}  // namespace

std::vector<int> select_facets(const SurfaceMesh& surface, const Selector& selector) {
  if (const auto* ray = std::get_if<NearestFaceSelector>(&selector)) {
    const int facet = first_hit(surface, *ray);
    return facet < 0 ? std::vector<int>{} : flat_face_of(surface, facet);
  }
  if (const auto* wanted = std::get_if<GroupSelector>(&selector)) return group(surface, *wanted);
  if (const auto* given = std::get_if<PatchSelector>(&selector)) return on_patch(surface, *given);
  if (const auto* face = std::get_if<CadFaceSelector>(&selector))
    return of_cad_face(surface, *face);
  if (const auto* painted = std::get_if<ColourSelector>(&selector))
    return of_colour(surface, *painted);
  const Membership belongs(surface);
  return facets_where(surface, [&](std::size_t f) {
    return std::visit(
        [&](const auto& kind) {
          if constexpr (std::is_invocable_v<Membership, decltype(kind), std::size_t>)
            return belongs(kind, f);
          else
            return false;
        },
        selector);
  });
}

std::string nearest_candidates(const SurfaceMesh& surface, const Selector& selector,
                               const std::string& unit) {
  return std::visit(Suggestion(surface, unit), selector);
}

Interface interface_on(const TetMesh& mesh, int tag) {
  Interface result;
  result.tag = tag;
  Vector3 first = Vector3::Zero();
  Matrix3 second = Matrix3::Zero();
  // Moments are summed about a point of the interface, so that a far origin costs no digits.
  Vector3 origin = Vector3::Zero();
  for (const BoundaryFace& face : mesh.boundary) {
    if (face.tag != tag) continue;
    if (result.faces++ == 0) origin = mesh.nodes[at(face.nodes[0])];
    for (std::size_t k = 0; k < mesh.nodes_per_face(); ++k) result.nodes.push_back(face.nodes[k]);
    if (has_curved_faces(mesh)) {
      integrate_face(mesh, face, [&](const FaceShapes&, const Vector3& point, double area) {
        result.area += area;
        first += area * (point - origin);
        second += area * (point - origin) * (point - origin).transpose();
      });
      continue;
    }
    const auto p = [&](std::size_t k) -> Vector3 { return mesh.nodes[at(face.nodes[k])] - origin; };
    const double area = 0.5 * (p(1) - p(0)).cross(p(2) - p(0)).norm();
    const Vector3 sum = p(0) + p(1) + p(2);
    result.area += area;
    first += area / 3 * sum;
    second += area / 12 *
              (p(0) * p(0).transpose() + p(1) * p(1).transpose() + p(2) * p(2).transpose() +
               sum * sum.transpose());
  }
  std::sort(result.nodes.begin(), result.nodes.end());
  result.nodes.erase(std::unique(result.nodes.begin(), result.nodes.end()), result.nodes.end());
  const Vector3 centre = first / result.area;
  result.centroid = origin + centre;
  const Matrix3 spread = second / result.area - centre * centre.transpose();
  const Eigen::SelfAdjointEigenSolver<Matrix3> eigen(spread);
  result.gyration = eigen.eigenvalues().reverse().cwiseMax(0).cwiseSqrt();
  result.principal_axes = eigen.eigenvectors().rowwise().reverse();
  return result;
}

}  // namespace kinetostat::fea
