#include "kinetostat/fea/mesh/tetrahedralize.h"

#include <algorithm>
#include <cmath>
#include <csignal>
#include <map>
#include <numeric>
#include <regex>
#include <sstream>
#include <system_error>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/common/child_process.h"
#include "kinetostat/common/deadline.h"
#include "kinetostat/common/index.h"
#include "kinetostat/fea/mesh/edge_division.h"
#include "kinetostat/fea/mesh/flat_elements.h"
#include "kinetostat/fea/mesh/tetgen_protocol.h"
#include "kinetostat/fea/surface/surface_check.h"
#include "kinetostat/fea/surface/surface_faces.h"
#include "kinetostat/io/text_file.h"

namespace kinetostat::fea {
namespace {

using common::at;

using Cause = MeshingError::Cause;

static_assert(tetgen::exit_out_of_memory == common::exit_out_of_memory);

constexpr const char* phase = "tetrahedra";

// TetGen joins coplanar facets of one marker and then ignores the edges between them, so that the
// triangulation of a flat face does not spoil the tetrahedra behind it. A marker is a flat face
// with one tag.
struct Markers {
  std::vector<std::int32_t> of_facet;
  std::vector<int> tag;  // of each marker
};

Markers mark(const SurfaceMesh& surface, const std::vector<int>& tags) {
  Markers markers{.of_facet = std::vector<std::int32_t>(surface.triangles.size()), .tag = {0}};
  for (const FlatFace& face : flat_faces(surface, weld_tolerance(surface.points))) {
    std::map<int, std::int32_t> marker_of_tag;
    for (const int facet : face.facets) {
      const auto f = at(facet);
      const auto [entry, is_new] =
          marker_of_tag.try_emplace(tags[f], static_cast<std::int32_t>(markers.tag.size()));
      if (is_new) markers.tag.push_back(tags[f]);
      markers.of_facet[f] = entry->second;
    }
  }
  return markers;
}

// Half way from a cavity's largest facet to what it faces.
Vector3 point_inside(const SurfaceMesh& surface, const Shell& cavity) {
  int largest = cavity.facets.front();
  for (const int f : cavity.facets)
    if (surface.area_vector(at(f)).norm() > surface.area_vector(at(largest)).norm()) largest = f;
  const auto start = at(largest);
  const Vector3 from = surface.centroid(start);
  const Vector3 direction = surface.area_vector(start).normalized();
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t f = 0; f < surface.triangles.size(); ++f)
    if (f != start) nearest = std::min(nearest, ray_hit(surface, f, from, direction));
  return std::isfinite(nearest) ? Vector3(from + 0.5 * nearest * direction) : from;
}

double regular_tetrahedron_volume(double edge) { return edge * edge * edge / (6 * std::sqrt(2.0)); }

tetgen::Request request_for(const SurfaceMesh& surface, const DividedSurface& divided,
                            const Markers& markers, const SurfaceReport& report,
                            const SizeField& sizes) {
  tetgen::Request request;
  for (const Vector3& p : divided.mesh.points)
    request.points.insert(request.points.end(), p.data(), p.data() + 3);
  for (const Triangle& t : divided.mesh.triangles)
    request.triangles.insert(request.triangles.end(), t.begin(), t.end());
  for (const int facet : divided.parent) request.markers.push_back(markers.of_facet[at(facet)]);
  for (const Shell& shell : report.shells) {
    if (shell.depth % 2 == 0) continue;
    const Vector3 inside = point_inside(surface, shell);
    request.holes.insert(request.holes.end(), inside.data(), inside.data() + 3);
  }
  for (std::size_t i = 0; i < sizes.points.size(); ++i) {
    const Vector3& p = sizes.points[i];
    request.sizes.insert(request.sizes.end(),
                         {p.x(), p.y(), p.z(), regular_tetrahedron_volume(sizes.sizes[i])});
  }
  return request;
}

void refuse_too_many(const SurfaceReport& report, const TetrahedralizeOptions& options) {
  if (!(options.edge_length > 0)) return;
  // TetGen's elements have a little over half the allowed volume on average.
  const double expected =
      1.7 * std::abs(report.volume) / regular_tetrahedron_volume(options.edge_length);
  const auto limit = static_cast<double>(options.largest_element_count);
  if (expected <= limit) return;
  throw MeshingError(Cause::too_many_elements,
                     fmt::format("an element size of {:.3g} m would give about {:.2g} elements, "
                                 "more than {:.2g}",
                                 options.edge_length, expected, limit),
                     fmt::format("Use a size of {:.3g} m or more",
                                 options.edge_length * std::cbrt(expected / limit)));
}

// Facets of the triangles that TetGen lists as "( 0, 2, 3) and ( 8, 12, 14)".
std::vector<int> facets_named(const std::string& words, const DividedSurface& surface) {
  std::map<Triangle, int> facet_of;
  for (std::size_t f = 0; f < surface.mesh.triangles.size(); ++f) {
    Triangle t = surface.mesh.triangles[f];
    std::sort(t.begin(), t.end());
    facet_of.emplace(t, surface.parent[f]);
  }
  static const std::regex triple(R"(\(\s*(\d{1,9}),\s*(\d{1,9}),\s*(\d{1,9})\))");
  std::vector<int> facets;
  std::istringstream lines(words);
  for (std::string line; std::getline(lines, line);) {
    if (line.size() > 200) continue;
    for (std::sregex_iterator m(line.begin(), line.end(), triple), end; m != end; ++m) {
      Triangle t{std::stoi((*m)[1]), std::stoi((*m)[2]), std::stoi((*m)[3])};
      std::sort(t.begin(), t.end());
      if (const auto entry = facet_of.find(t); entry != facet_of.end())
        facets.push_back(entry->second);
    }
  }
  std::sort(facets.begin(), facets.end());
  facets.erase(std::unique(facets.begin(), facets.end()), facets.end());
  return facets;
}

bool succeeded(const common::ChildResult& result) {
  return result.end == common::ChildResult::End::exited && result.code == tetgen::exit_done;
}

// Runs of the helper on one surface with different switches.
class Mesher {
 public:
  Mesher(tetgen::Request request, const TetrahedralizeOptions& options, common::Progress& progress)
      : request_(std::move(request)), options_(options), progress_(progress) {
    helper_ = options.helper.empty() ? common::find_helper("kinetostat-tetgen") : options.helper;
    if (helper_.empty())
      throw MeshingError(Cause::no_helper, "the helper program kinetostat-tetgen was not found",
                         "It belongs beside the kinetostat program: install it again");
  }

  common::ChildResult run(const std::string& switches, double time_limit) {
    request_.switches = switches;
    const std::string input = tetgen::encode(request_);
    const std::string key = options_.cache == nullptr ? "" : cache_key(input);
    if (options_.cache != nullptr)
      if (auto answer = options_.cache->find(key))
        return {.answer = *std::move(answer), .words = {}};
    common::ChildResult result = run_helper(input, time_limit);
    if (options_.cache != nullptr && succeeded(result)) options_.cache->keep(key, result.answer);
    return result;
  }

 private:
  // The same request has the same answer as long as the helper is the same program.
  std::string cache_key(const std::string& input) const {
    return "tetrahedra " + io::sha256(io::read_text(helper_)) + input;
  }

  common::ChildResult run_helper(const std::string& input, double time_limit) {
    try {
      return common::run_child({.program = helper_,
                                .arguments = {"--memory", std::to_string(options_.memory_limit)},
                                .input = input,
                                .time_limit = time_limit},
                               phase, progress_);
    } catch (const std::system_error& error) {
      throw MeshingError(Cause::no_helper,
                         fmt::format("the helper program cannot be run: {}", error.what()),
                         "It belongs beside the kinetostat program: install it again");
    }
  }

  tetgen::Request request_;
  const TetrahedralizeOptions& options_;
  common::Progress& progress_;
  std::filesystem::path helper_;
};

// TetGen may ignore edges within a face, unless the facets shall stay.
DividedSurface divided_for(ElementShape shape, const SurfaceMesh& surface, const Markers& markers,
                           const TetrahedralizeOptions& options) {
  if (shape != ElementShape::kept && shape != ElementShape::any)
    return divide_edges(surface, markers.of_facet, options.sizes);
  std::vector<std::int32_t> faces(surface.triangles.size());
  std::iota(faces.begin(), faces.end(), 0);
  if (options.sizes.empty() && options.edge_length > 0)
    return divide_edges(surface, faces,
                        {.points = {surface.points.front()}, .sizes = {options.edge_length}});
  return divide_edges(surface, faces, options.sizes);
}

std::string switches(ElementShape shape, const TetrahedralizeOptions& options) {
  const std::string size =
      options.edge_length > 0
          ? fmt::format("a{:.40f}", regular_tetrahedron_volume(options.edge_length))
          : "";
  const double ratio = options.radius_edge_ratio;
  switch (shape) {
    case ElementShape::good:
      return fmt::format("pq{:.3f}/{:.1f}{}", ratio, options.least_dihedral, size);
    case ElementShape::fair:
      return fmt::format("pq{:.3f}{}", ratio, size);
    case ElementShape::rough:
      return "pq2" + size;
    case ElementShape::kept:
      return "pYq2" + size;
    case ElementShape::any:
      return "p";
  }
  return {};
}

[[noreturn]] void explain(const common::ChildResult& result, const TetrahedralizeOptions& options,
                          std::vector<int> facets) {
  std::string where;
  if (!facets.empty()) {
    std::vector<int> shown;
    for (std::size_t i = 0; i < std::min<std::size_t>(facets.size(), 8); ++i)
      shown.push_back(facets[i] + 1);
    where = fmt::format("; the facets concerned are {}{}", fmt::join(shown, ", "),
                        facets.size() > shown.size() ? ", ..." : "");
  }
  const std::string check = "See 'kinetostat mesh check'; export the mesh with a finer tolerance";
  if (result.end == common::ChildResult::End::timed_out)
    throw MeshingError(
        Cause::timed_out,
        fmt::format("TetGen was stopped after {:.0f} s{}", options.time_limit, where),
        "Use a larger element size or a longer time limit", std::move(facets));
  if (result.ran_out_of_memory())
    throw MeshingError(Cause::out_of_memory,
                       fmt::format("TetGen needs more memory than there is, or than the {:.1f} GiB "
                                   "that it may take",
                                   static_cast<double>(options.memory_limit) / (1 << 30)),
                       "Use a larger element size", std::move(facets));
  if (result.end == common::ChildResult::End::killed_by_signal)
    throw MeshingError(
        Cause::crashed,
        fmt::format("TetGen crashed on this surface ({}){}", strsignal(result.code), where), check,
        std::move(facets));
  if (result.code > tetgen::refused_base)
    throw MeshingError(Cause::refused,
                       fmt::format("TetGen refused this surface (its code {}){}",
                                   result.code - tetgen::refused_base, where),
                       check, std::move(facets));
  throw MeshingError(Cause::crashed,
                     fmt::format("the TetGen helper ended with code {}{}", result.code, where),
                     check, std::move(facets));
}

void orient(Eigen::Ref<Eigen::Vector4i> tet, const std::vector<Vector3>& nodes) {
  const auto p = [&](int k) { return nodes[at(tet[k])]; };
  if (volume({p(0), p(1), p(2), p(3)}) < 0) std::swap(tet[2], tet[3]);
}

// Boundary faces seen counterclockwise from outside: away from the corner behind them.
void orient_boundary(TetMesh& mesh) {
  struct Side {
    Triangle sorted;
    int opposite;
    bool operator<(const Side& other) const { return sorted < other.sorted; }
  };
  std::vector<Side> sides;
  std::vector<bool> on_boundary(mesh.nodes.size(), false);
  for (const BoundaryFace& face : mesh.boundary)
    for (std::size_t k = 0; k < 3; ++k) on_boundary[at(face.nodes[k])] = true;
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    const auto tet = mesh.element(e);
    for (std::size_t k = 0; k < 4; ++k) {
      Triangle t{tet[(k + 1) % 4], tet[(k + 2) % 4], tet[(k + 3) % 4]};
      if (!std::all_of(t.begin(), t.end(), [&](int n) { return on_boundary[at(n)]; })) continue;
      std::sort(t.begin(), t.end());
      sides.push_back({t, tet[k]});
    }
  }
  std::sort(sides.begin(), sides.end());
  for (BoundaryFace& face : mesh.boundary) {
    Triangle t{face.nodes[0], face.nodes[1], face.nodes[2]};
    std::sort(t.begin(), t.end());
    const auto side = std::lower_bound(sides.begin(), sides.end(), Side{t, 0});
    if (side == sides.end() || side->sorted != t)
      throw MeshingError(Cause::crashed, "TetGen returned a boundary face of no element",
                         "Report this with the mesh file");
    const auto p = [&](int n) { return mesh.nodes[at(n)]; };
    if (volume({p(face.nodes[0]), p(face.nodes[1]), p(face.nodes[2]), p(side->opposite)}) > 0)
      std::swap(face.nodes[1], face.nodes[2]);
  }
}

bool is_consistent(const tetgen::Answer& answer, std::size_t marker_count) {
  const auto points = static_cast<std::int32_t>(answer.points.size() / 3);
  const auto in_range = [points](std::int32_t n) { return n >= 0 && n < points; };
  return !answer.tetrahedra.empty() && answer.points.size() % 3 == 0 &&
         answer.tetrahedra.size() % 4 == 0 &&
         answer.triangles.size() == 3 * answer.markers.size() &&
         std::all_of(answer.tetrahedra.begin(), answer.tetrahedra.end(), in_range) &&
         std::all_of(answer.triangles.begin(), answer.triangles.end(), in_range) &&
         std::all_of(answer.markers.begin(), answer.markers.end(),
                     [marker_count](std::int32_t m) { return m > 0 && at(m) < marker_count; });
}

TetMesh mesh_from(const common::ChildResult& result, const Markers& markers) {
  tetgen::Answer answer;
  if (!tetgen::decode(result.answer, answer) || !is_consistent(answer, markers.tag.size()))
    throw MeshingError(Cause::crashed, "the TetGen helper did not answer as agreed",
                       "Is kinetostat-tetgen of the same version as kinetostat?");
  TetMesh mesh;
  for (std::size_t i = 0; i + 2 < answer.points.size(); i += 3)
    mesh.nodes.emplace_back(answer.points[i], answer.points[i + 1], answer.points[i + 2]);
  mesh.connectivity.assign(answer.tetrahedra.begin(), answer.tetrahedra.end());
  for (std::size_t e = 0; e < mesh.element_count(); ++e)
    orient(Eigen::Map<Eigen::Vector4i>(mesh.connectivity.data() + 4 * e), mesh.nodes);
  for (std::size_t f = 0; f < answer.markers.size(); ++f)
    mesh.boundary.push_back({.nodes = {answer.triangles[3 * f], answer.triangles[3 * f + 1],
                                       answer.triangles[3 * f + 2], -1, -1, -1},
                             .tag = markers.tag[at(answer.markers[f])]});
  orient_boundary(mesh);
  return mesh;
}

}  // namespace

MeshingError::MeshingError(Cause cause, const std::string& what, const std::string& cure,
                           std::vector<int> facets)
    : std::runtime_error(what), cause_(cause), cure_(cure), facets_(std::move(facets)) {}

TetMesh tetrahedralize(const SurfaceMesh& surface, const std::vector<int>& tags,
                       const TetrahedralizeOptions& options, common::Progress& progress) {
  if (tags.size() != surface.triangles.size())
    throw std::invalid_argument(fmt::format("tetrahedralize: {} tags for {} facets", tags.size(),
                                            surface.triangles.size()));
  const common::Deadline deadline(options.time_limit);
  const SurfaceReport report = check_surface(surface, weld_tolerance(surface.points));
  refuse_too_many(report, options);
  const Markers markers = mark(surface, tags);
  common::ChildResult first_failure{
      .end = common::ChildResult::End::timed_out, .answer = {}, .words = {}};
  DividedSurface failed_on;
  bool failed = false;
  std::size_t flat = 0;
  for (std::size_t i = 0; i < options.shapes.size() && deadline.left() > 0; ++i) {
    const double share = i + 1 < options.shapes.size() ? 0.5 : 1;
    const ElementShape shape = options.shapes[i];
    DividedSurface divided = divided_for(shape, surface, markers, options);
    Mesher mesher(request_for(surface, divided, markers, report, options.sizes), options, progress);
    const common::ChildResult result =
        mesher.run(switches(shape, options), share * deadline.left());
    if (succeeded(result)) {
      TetMesh mesh = mesh_from(result, markers);
      const std::size_t left = remove_flat_elements(mesh);
      if (left == 0 || !has_flat_elements(mesh)) return reordered(mesh);
      flat = left;
    } else if (!failed) {
      failed = true;
      first_failure = result;
      failed_on = std::move(divided);
    }
  }
  if (flat > 0)
    throw MeshingError(Cause::refused,
                       fmt::format("TetGen left {} flat elements on this surface", flat),
                       "Export the mesh again with a finer tolerance, or change the element size");
  std::vector<int> facets = facets_named(first_failure.words, failed_on);
  if (facets.empty() && options.name_facets)
    facets = crossing_facets(surface, tags, options, deadline.left(), progress);
  explain(first_failure, options, std::move(facets));
}

std::vector<int> crossing_facets(const SurfaceMesh& surface, const std::vector<int>& tags,
                                 const TetrahedralizeOptions& options, double time,
                                 common::Progress& progress) {
  constexpr double search_time = 20, least_time = 0.5;  // [s]
  if (time < least_time) return {};
  const Markers markers = mark(surface, tags);
  const DividedSurface divided = divide_edges(surface, markers.of_facet, options.sizes);
  Mesher mesher(request_for(surface, divided, markers, {}, {}), options, progress);
  return facets_named(mesher.run("pd", std::min(time, search_time)).words, divided);
}

}  // namespace kinetostat::fea
