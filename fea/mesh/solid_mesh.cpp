#include "kinetostat/fea/mesh/solid_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numeric>

#include <fmt/format.h>

#include "kinetostat/common/deadline.h"
#include "kinetostat/common/index.h"
#include "kinetostat/fea/mesh/flat_elements.h"
#include "kinetostat/fea/mesh/gmsh_program.h"
#include "kinetostat/fea/surface/cgal_program.h"
#include "kinetostat/fea/surface/surface_check.h"
#include "kinetostat/fea/surface/surface_distance.h"
#include "kinetostat/fea/surface/surface_faces.h"

namespace kinetostat::fea {
namespace {

using common::at;

using Cause = MeshingError::Cause;

// -- The ladder -----------------------------------------------------------------------------------

enum SurfaceKind { as_given, thin_1e6, thin_1e5, thin_1e4, remeshed_fine, remeshed_coarse };

// All as fractions of the diagonal of the bounding box.
struct SurfaceMaking {
  const char* words;
  double tolerance;    // of facets that are removed; 0: the surface is remeshed, or given
  double edge_length;  // of remeshed facets; halved, and halved again, while it moves too far
  double deviation;    // that is allowed
};

constexpr std::array<SurfaceMaking, 6> surfaces{{
    {"the surface as it is", 0, 0, 0},
    {"the surface without facets thinner than 1e-6 of the diagonal", 1e-6, 0, 1e-5},
    {"the surface without facets thinner than 1e-5 of the diagonal", 1e-5, 0, 5e-5},
    {"the surface without facets thinner than 1e-4 of the diagonal", 1e-4, 0, 3e-4},
    {"the surface remeshed within 3e-4 of the diagonal", 0, 0.02, 3e-4},
    {"the surface remeshed within 1e-3 of the diagonal", 0, 0.02, 1e-3},
}};

enum class Program { tetgen, gmsh };

struct Rung {
  SurfaceKind surface;
  Program program;
  ElementShape shape;  // of TetGen's elements
  double share;        // of the time that is left
};

// First what keeps the surface, with elements as good as can be had, then what moves it least.
constexpr std::array ladder{
    Rung{as_given, Program::tetgen, ElementShape::good, 0.3},
    Rung{as_given, Program::tetgen, ElementShape::rough, 0.2},
    Rung{as_given, Program::tetgen, ElementShape::any, 0.4},
    Rung{as_given, Program::tetgen, ElementShape::kept, 0.15},
    Rung{thin_1e6, Program::tetgen, ElementShape::good, 0.15},
    Rung{thin_1e6, Program::tetgen, ElementShape::any, 0.15},
    Rung{thin_1e5, Program::tetgen, ElementShape::good, 0.15},
    Rung{thin_1e5, Program::tetgen, ElementShape::any, 0.25},
    Rung{as_given, Program::gmsh, ElementShape::any, 0.2},
    Rung{thin_1e4, Program::tetgen, ElementShape::good, 0.2},
    Rung{thin_1e4, Program::tetgen, ElementShape::any, 0.2},
    Rung{remeshed_fine, Program::tetgen, ElementShape::good, 0.3},
    Rung{remeshed_fine, Program::tetgen, ElementShape::kept, 0.3},
    Rung{remeshed_fine, Program::tetgen, ElementShape::any, 0.3},
    Rung{remeshed_coarse, Program::tetgen, ElementShape::good, 0.3},
    Rung{remeshed_coarse, Program::tetgen, ElementShape::any, 0.5},
    Rung{remeshed_coarse, Program::gmsh, ElementShape::any, 1},
};
constexpr double share_of_later_meshes = 0.6;  // for the rung that made the one before

// To start with; a first mesh that has more may be made again by the next rung on the same surface.
constexpr std::size_t comfortable_elements = 300'000;
constexpr double most_good_elements = 600'000;

std::string words(const Rung& rung) {
  static constexpr const char* shapes[] = {"", ", elements of fair shape", ", rough elements",
                                           ", its facets kept", ", elements of any shape"};
  return fmt::format(
      "{} on {}{}", rung.program == Program::tetgen ? "TetGen" : "gmsh",
      surfaces[rung.surface].words,
      rung.program == Program::tetgen ? shapes[static_cast<std::size_t>(rung.shape)] : "");
}

// -- Surfaces -------------------------------------------------------------------------------------

double volume_of(const SurfaceMesh& surface) { return mass_properties(surface).volume; }

SurfaceDeviation deviation_of(const SurfaceMesh& mesh, const SurfaceMesh& given, double allowed) {
  const SurfaceLocator on_mesh(mesh), on_given(given);
  const double spacing = 0.01 * bounding_box(given.points).diagonal().norm();
  return {.allowed = allowed,
          .distance = std::max(farthest_distance(mesh, on_given, spacing),
                               farthest_distance(given, on_mesh, spacing)),
          .volume_change = volume_of(mesh) / volume_of(given) - 1};
}

// Why this surface is none to mesh instead of the given one; empty when it is.
std::string fault(const SurfaceMesh& mesh, const SurfaceDeviation& deviation) {
  if (deviation.distance > deviation.allowed)
    return fmt::format("it would be {:.2g} m off, {:.2g} m are allowed", deviation.distance,
                       deviation.allowed);
  if (!(std::abs(deviation.volume_change) <= most_volume_change))
    return fmt::format("its volume would change by {:+.2g} %, {:.2g} % are allowed",
                       100 * deviation.volume_change, 100 * most_volume_change);
  if (const SurfaceReport report = check_surface(mesh, weld_tolerance(mesh.points));
      !report.sound() || report.bodies() != 1)
    return "it would not bound a solid";
  return {};
}

// Every tag of the given surface is still there.
bool keeps_tags(const std::vector<int>& tags, const std::vector<int>& given) {
  return std::all_of(given.begin(), given.end(), [&](int tag) {
    return std::find(tags.begin(), tags.end(), tag) != tags.end();
  });
}

// -- Meshes ---------------------------------------------------------------------------------------

// Gmsh gets one size for all: the mean of what is wished for.
double one_size(const TetrahedralizeOptions& options) {
  const std::vector<double>& sizes = options.sizes.sizes;
  if (sizes.empty()) return options.edge_length;
  const double mean =
      std::accumulate(sizes.begin(), sizes.end(), 0.0) / static_cast<double>(sizes.size());
  return options.edge_length > 0 ? std::min(mean, options.edge_length) : mean;
}

// Good elements are about as small as the walls are thick, in the mean 2 V / A, and as needles are
// wide, unless these lie in a flat face. The factors are those of TetGen's meshes.
double good_element_count(const SurfaceMesh& surface) {
  const double area = area_of(surface);
  double needles = 0;
  for (const FlatFace& face : flat_faces(surface, weld_tolerance(surface.points))) {
    constexpr std::size_t two_of_a_strip = 2;
    if (face.facets.size() > two_of_a_strip) continue;
    for (const int f : face.facets) {
      const auto facet = at(f);
      double longest = 0;
      for (std::size_t k = 0; k < 3; ++k)
        longest = std::max(longest,
                           (surface.corner(facet, (k + 1) % 3) - surface.corner(facet, k)).norm());
      if (const double own = surface.area_vector(facet).norm(); own > 0)
        needles += longest * longest / own;
    }
  }
  const double thickness = 2 * volume_of(surface) / area;
  return std::max(2.2 * area / (thickness * thickness), needles);
}

// Why a mesh is no mesh of this solid; empty when it is one.
std::string fault(const TetMesh& mesh, const SurfaceMesh& surface) {
  const double wanted = volume_of(surface), got = mass_properties(mesh).volume;
  if (!(std::abs(got - wanted) <= 1e-5 * wanted))
    return fmt::format("its mesh has {:.6g} times the volume of the surface", got / wanted);
  return has_flat_elements(mesh) ? "its mesh has flat elements" : "";
}

}  // namespace

// One run down the ladder.
class SolidMesher::Attempt {
 public:
  Attempt(SolidMesher& mesher, const TetrahedralizeOptions& options, common::Progress& progress)
      : mesher_(mesher),
        options_(options),
        progress_(progress),
        deadline_(options.time_limit - mesher.time_used_),
        diagonal_(bounding_box(mesher.surface_.points).diagonal().norm()) {}
  ~Attempt() { mesher_.time_used_ += deadline_.elapsed(); }
  Attempt(const Attempt&) = delete;
  Attempt& operator=(const Attempt&) = delete;

  // The mesh, or none with the reason in the record.
  std::optional<TetMesh> on(const Rung& rung) {
    if (is_out_of_time()) {
      fail(rung, "no time is left");
      return {};
    }
    const common::Deadline own(time_for(rung));
    const Prepared& prepared = surface(rung.surface, 0.5 * own.left());
    std::string obstacle = prepared.fault;
    if (obstacle.empty() && !(own.left() > 0)) obstacle = "its time went into the surface";
    if (obstacle.empty()) obstacle = waste(rung, prepared);
    std::optional<TetMesh> mesh;
    if (obstacle.empty()) mesh = filled(rung, prepared, own.left(), obstacle);
    if (!mesh) fail(rung, obstacle);
    return mesh;
  }

  void keep(const Rung& rung) {
    mesher_.record_.way = words(rung);
    mesher_.record_.deviation = mesher_.prepared_[rung.surface].deviation;
  }
  void fail(const Rung& rung, const std::string& reason) {
    mesher_.record_.failures.push_back({words(rung), reason});
  }
  bool is_large(const TetMesh& mesh) const {
    return mesher_.record_.way.empty() && !(options_.edge_length > 0) &&
           mesh.element_count() > comfortable_elements;
  }

  // Of a mesh that says how many it may have.
  bool is_too_large(const TetMesh& mesh) const {
    return options_.most_elements > 0 && mesh.element_count() > options_.most_elements;
  }

  [[noreturn]] void give_up() {
    std::string also;
    const std::vector<MeshingFailure>& failures = mesher_.record_.failures;
    for (std::size_t i = 1; i < failures.size(); ++i)
      also += fmt::format("; {}: {}", failures[i].way, failures[i].reason);
    if (!first_) first_ = MeshingError(Cause::refused, failures.front().reason, "");
    if (out_of_memory_)
      throw MeshingError(Cause::out_of_memory, first_->what() + also,
                         "Use a larger element size, or close other programs");
    const std::vector<int> facets =
        crossing_facets(mesher_.surface_, mesher_.tags_, options_, deadline_.left(), progress_);
    throw MeshingError(first_->cause(), first_->what() + also, first_->cure(),
                       first_->facets().empty() ? facets : first_->facets());
  }

 private:
  // Shares of what is left never add up to all of it.
  bool is_out_of_time() const { return deadline_.left() < 0.02 * options_.time_limit; }
  double time_for(const Rung& rung) const {
    const bool is_later = !mesher_.record_.way.empty();
    return std::max(rung.share, is_later ? share_of_later_meshes : 0) * deadline_.left();
  }

  // None where `obstacle` says why.
  std::optional<TetMesh> filled(const Rung& rung, const Prepared& prepared, double time,
                                std::string& obstacle) {
    const SurfaceMesh& mesh = prepared.surface ? prepared.surface->mesh : mesher_.surface_;
    const std::vector<int>& tags = prepared.surface ? prepared.surface->tags : mesher_.tags_;
    try {
      TetMesh made = rung.program == Program::tetgen ? by_tetgen(rung, mesh, tags, time)
                                                     : by_gmsh(mesh, tags, time);
      made.made_by = words(rung);
      obstacle = fault(made, mesh);
      if (obstacle.empty()) return made;
    } catch (const MeshingError& error) {
      if (error.cause() == Cause::no_helper || error.cause() == Cause::too_many_elements) throw;
      if (!first_) first_ = error;
      out_of_memory_ |= error.cause() == Cause::out_of_memory;
      obstacle = error.what();
    } catch (const GmshError& error) {
      out_of_memory_ |= error.out_of_memory();
      obstacle = error.what();
    }
    return {};
  }

  // Why a mesh would take long and could not be used; empty when it could.
  std::string waste(const Rung& rung, const Prepared& prepared) const {
    if (rung.program != Program::tetgen || options_.edge_length > 0) return {};
    if (rung.shape != ElementShape::good && rung.shape != ElementShape::rough) return {};
    if (prepared.good_elements < most_good_elements) return {};
    return fmt::format(
        "about {:.1g} elements would be needed where walls are thin and facets narrow",
        prepared.good_elements);
  }

  TetMesh by_tetgen(const Rung& rung, const SurfaceMesh& mesh, const std::vector<int>& tags,
                    double time) {
    TetrahedralizeOptions options = options_;
    options.shapes = {rung.shape};
    options.time_limit = time;
    options.name_facets = false;
    return tetrahedralize(mesh, tags, options, progress_);
  }
  TetMesh by_gmsh(const SurfaceMesh& mesh, const std::vector<int>& tags, double time) {
    TetMesh made = gmsh_tetrahedra(mesh, tags, one_size(options_),
                                   {.time = time, .memory = options_.memory_limit}, progress_);
    remove_flat_elements(made);
    return reordered(made);
  }

  // Made once for all meshes of this solid.
  const Prepared& surface(SurfaceKind kind, double time) {
    const auto [entry, is_new] = mesher_.prepared_.try_emplace(kind);
    Prepared& prepared = entry->second;
    if (!is_new) return prepared;
    if (kind != as_given) prepared = make(surfaces[kind], time);
    prepared.good_elements =
        good_element_count(prepared.surface ? prepared.surface->mesh : mesher_.surface_);
    return prepared;
  }
  Prepared make(const SurfaceMaking& making, double time) {
    const double allowed = making.deviation * diagonal_;
    if (making.edge_length > 0) return remesh(making, allowed, time);
    std::optional<CleanSurface> clean =
        without_thin_facets(mesher_.surface_, mesher_.tags_, making.tolerance * diagonal_);
    if (!clean) return {.surface = {}, .deviation = {}, .fault = "there are none that can go"};
    return judged(*std::move(clean), allowed);
  }
  Prepared judged(CleanSurface surface, double allowed) {
    const SurfaceDeviation deviation = deviation_of(surface.mesh, mesher_.surface_, allowed);
    std::string wrong = keeps_tags(surface.tags, mesher_.tags_) ? fault(surface.mesh, deviation)
                                                                : "an interface would be lost";
    return {.surface = std::move(surface), .deviation = deviation, .fault = std::move(wrong)};
  }
  Prepared remesh(const SurfaceMaking& making, double allowed, double time) {
    const common::Deadline deadline(time);
    Prepared prepared;
    for (const double part : {1.0, 0.5, 0.25}) {
      if (!(deadline.left() > 0)) break;
      CgalResult result = ask_cgal(mesher_.surface_,
                                   {.operation = "remesh",
                                    .numbers = {part * making.edge_length * diagonal_, sharp_angle},
                                    .markers = mesher_.tags_,
                                    .time_limit = deadline.left(),
                                    .helper = options_.remesher},
                                   "remeshing", progress_);
      out_of_memory_ |= result.out_of_memory;
      if (!result.fault.empty())
        return {.surface = {}, .deviation = {}, .fault = std::move(result.fault)};
      prepared = judged({std::move(result.mesh), std::move(result.markers)}, allowed);
      if (prepared.fault.empty()) break;
    }
    return prepared;
  }

  static constexpr double sharp_angle = 20;  // [deg] edges that turn by more stay where they are

  SolidMesher& mesher_;
  const TetrahedralizeOptions& options_;
  common::Progress& progress_;
  common::Deadline deadline_;
  double diagonal_;
  std::optional<MeshingError> first_;
  bool out_of_memory_ = false;  // some attempt was
};

TetMesh SolidMesher::fill(const TetrahedralizeOptions& options, common::Progress& progress) {
  if (time_used_ >= options.time_limit)
    throw MeshingError(
        Cause::timed_out,
        fmt::format("meshing has taken the {:g} s that it may take", options.time_limit),
        "Allow more (--mesh-time)");
  Attempt attempt(*this, options, progress);
  std::optional<TetMesh> large;
  std::size_t rung_of_large = 0;
  for (; rung_ < ladder.size(); ++rung_) {
    if (large && ladder[rung_].surface != ladder[rung_of_large].surface) break;
    std::optional<TetMesh> mesh = attempt.on(ladder[rung_]);
    if (!mesh) continue;
    if (attempt.is_too_large(*mesh)) {
      attempt.fail(ladder[rung_],
                   fmt::format("{} elements are far more than were asked for, as where facets are "
                               "narrow or nearly cross",
                               mesh->element_count()));
      continue;
    }
    if (!attempt.is_large(*mesh)) {
      attempt.keep(ladder[rung_]);
      return *std::move(mesh);
    }
    attempt.fail(ladder[rung_],
                 fmt::format("{} elements are many to start with", mesh->element_count()));
    if (large && large->element_count() <= mesh->element_count()) continue;
    large = std::move(mesh);
    rung_of_large = rung_;
  }
  if (!large) attempt.give_up();
  rung_ = rung_of_large;
  attempt.keep(ladder[rung_]);
  return *std::move(large);
}

}  // namespace kinetostat::fea
