#include "kinetostat/fea/surface/surface_repair.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>

#include <fmt/format.h>

#include "kinetostat/common/index.h"
#include "kinetostat/common/out_of_memory.h"
#include "kinetostat/fea/surface/cgal_program.h"
#include "kinetostat/fea/surface/surface_bodies.h"
#include "kinetostat/fea/surface/surface_cleaning.h"
#include "kinetostat/fea/surface/surface_distance.h"
#include "kinetostat/fea/surface/surface_flattening.h"
#include "kinetostat/fea/surface/surface_topology.h"
#include "kinetostat/fea/surface/surface_weld.h"
#include "kinetostat/spatial/units.h"

namespace kinetostat::fea {
namespace {

using common::at;

constexpr const char* phase = "repair";

bool has(const SurfaceReport& report, DefectKind kind) {
  return std::any_of(report.defects.begin(), report.defects.end(),
                     [kind](const Defect& defect) { return defect.kind == kind; });
}

const std::vector<int>& facets_of(const SurfaceReport& report, DefectKind kind) {
  static const std::vector<int> none;
  for (const Defect& defect : report.defects)
    if (defect.kind == kind) return defect.facets;
  return none;
}

// Facets without area that hang on by one edge close nothing. Returns how many there were.
std::size_t remove_loose_slivers(const SurfaceReport& report, SurfaceMesh& mesh) {
  const std::vector<int>& open = facets_of(report, DefectKind::open_edge);
  const std::vector<int>& thin = facets_of(report, DefectKind::degenerate_facet);
  std::vector<int> loose;
  std::set_intersection(open.begin(), open.end(), thin.begin(), thin.end(),
                        std::back_inserter(loose));
  std::vector<int> kept(mesh.triangles.size(), 0);
  for (const int f : loose) kept[at(f)] = -1;
  int count = 0;
  for (int& number : kept)
    if (number == 0) number = count++;
  keep_facets(mesh, kept);
  return loose.size();
}

std::size_t count_of(const SurfaceReport& report, DefectKind kind) {
  for (const Defect& defect : report.defects)
    if (defect.kind == kind) return defect.count;
  return 0;
}

bool is_one_solid(const SurfaceReport& report) { return report.sound() && report.bodies() == 1; }

std::string counted(std::size_t n, const char* one, const char* many) {
  return fmt::format("{} {}", n, n == 1 ? one : many);
}

// From the last of the helper's counts.
std::string sheets_left_out(const std::vector<std::int64_t>& counts) {
  if (counts.empty() || counts.back() == 0) return {};
  return ", " + counted(at(counts.back()), "sheet without volume left out",
                        "sheets without volume left out");
}

// New facets belong to the groups of the old facets that they lie on.
void carry_groups(const SurfaceMesh& old, const SurfaceLocator& locator, double reach,
                  SurfaceMesh& mesh) {
  if (old.groups.empty()) return;
  mesh.faces = old.faces;
  std::vector<std::vector<int>> groups_of(old.triangles.size());
  for (std::size_t g = 0; g < old.groups.size(); ++g) {
    mesh.groups.push_back({old.groups[g].name, {}});
    for (const int f : old.groups[g].facets) groups_of[at(f)].push_back(static_cast<int>(g));
  }
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    const SurfaceLocator::Place place = locator.nearest(mesh.centroid(f));
    if (place.distance > reach) continue;
    for (const int g : groups_of[at(place.facet)])
      mesh.groups[at(g)].facets.push_back(static_cast<int>(f));
  }
  std::erase_if(mesh.groups, [](const FacetGroup& group) { return group.facets.empty(); });
}

class Repair {
 public:
  Repair(SurfaceMesh& mesh, const RepairOptions& options, common::Progress& progress)
      : mesh_(mesh),
        options_(options),
        progress_(progress),
        diagonal_(bounding_box(mesh.points).diagonal().norm()),
        contact_(weld_tolerance(mesh.points)),
        length_(spatial::parse_quantity("1 " + options.unit, spatial::dimension::length)),
        state_(check_surface(mesh, contact_)) {}

  RepairReport run() && {
    if (is_one_solid(state_)) return std::move(report_);
    take(RepairStep::weld, &Repair::weld_edges);
    take(RepairStep::orient, &Repair::orient);
    // Only now does "inside" mean something.
    original_ = mesh_;
    locator_.emplace(original_);
    report_.volume_before = enclosed_volume(original_);
    // Rounding to what a file holds may spoil what was just united.
    for (int round = 0; round < (options_.stored_unit > 0 ? 3 : 1); ++round) {
      take(RepairStep::fill, &Repair::fill);
      take(RepairStep::unite, &Repair::unite);
      take(RepairStep::drop, &Repair::drop);
    }
    take(RepairStep::wrap, &Repair::wrap);
    report_.volume_after = enclosed_volume(mesh_).value_or(0);
    return std::move(report_);
  }

 private:
  void take(RepairStep step, void (Repair::*work)()) {
    const bool allowed =
        std::find(options_.steps.begin(), options_.steps.end(), step) != options_.steps.end();
    if (!allowed || is_one_solid(state_)) return;
    progress_.report(phase, 0);
    (this->*work)();
    if (options_.stored_unit > 0) round_as_stored();
  }
  // As the file is read again.
  void round_as_stored() {
    for (Vector3& p : mesh_.points)
      p = options_.stored_unit * (p / options_.stored_unit).cast<float>().cast<double>();
    weld(mesh_, weld_tolerance(mesh_.points));
    state_ = check_surface(mesh_, contact_);
  }
  void log(RepairStep step, bool done, std::string words) {
    report_.actions.push_back({step, done, std::move(words)});
  }
  std::string length(double metres) const {
    return fmt::format("{:.3g} {}", metres / length_, options_.unit);
  }

  void weld_edges() {
    if (!has(state_, DefectKind::open_edge) && !has(state_, DefectKind::non_manifold_edge) &&
        !has(state_, DefectKind::duplicate_facet))
      return;
    const double tolerance = options_.tolerance > 0 ? options_.tolerance : 1e-4 * diagonal_;
    SurfaceMesh welded = mesh_;
    const std::size_t loose = remove_loose_slivers(state_, welded);
    EdgeWeldReport did = weld_open_edges(welded, tolerance);
    did.removed += loose;
    if (did.joined + did.split + did.removed == 0) return;
    if (welded.triangles.empty())
      return log(RepairStep::weld, false, "nothing would be left of the surface");
    const std::size_t moved = did.joined + did.split > 0 ? flatten(welded, tolerance) : 0;
    mesh_ = std::move(welded);
    state_ = check_surface(mesh_, contact_);
    log(RepairStep::weld, true,
        fmt::format("{} joined within {}, {} split at a corner, {} moved into the plane of a flat "
                    "face, {} removed",
                    counted(did.joined, "corner", "corners"), length(tolerance),
                    counted(did.split, "open edge", "open edges"),
                    counted(moved, "corner", "corners"),
                    counted(did.removed, "facet that was there twice or collapsed",
                            "facets that were there twice or collapsed")));
  }

  void orient() {
    const std::size_t turned = orient_outward(mesh_);
    if (turned == 0) return;
    state_ = check_surface(mesh_, contact_);
    log(RepairStep::orient, true, counted(turned, "facet turned", "facets turned"));
  }

  // The helper's mesh, or none with the reason logged.
  [[noreturn]] void lacks_memory(RepairStep step) const {
    throw common::OutOfMemory(
        fmt::format("the step '{}' needs more memory than there is, or than the {:.1f} GiB that "
                    "it may take",
                    name(step), static_cast<double>(options_.memory_limit) / (1 << 30)),
        "Close other programs, or export a coarser mesh");
  }
  std::optional<SurfaceMesh> ask_helper(RepairStep step, std::vector<double> numbers,
                                        std::vector<std::int64_t>* counts = nullptr) {
    CgalResult result = ask_cgal(mesh_,
                                 {.operation = name(step),
                                  .numbers = std::move(numbers),
                                  .time_limit = options_.time_limit,
                                  .memory_limit = options_.memory_limit,
                                  .helper = options_.helper},
                                 phase, progress_);
    if (result.out_of_memory) lacks_memory(step);
    if (!result.fault.empty()) {
      log(step, false, result.fault);
      return {};
    }
    if (counts != nullptr) *counts = std::move(result.counts);
    return std::move(result.mesh);
  }

  void fill() {
    const std::size_t open = count_of(state_, DefectKind::open_edge);
    if (open == 0) return;
    std::vector<std::int64_t> counts;
    std::optional<SurfaceMesh> filled = ask_helper(RepairStep::fill, {}, &counts);
    if (!filled) return;
    remove_repeated_facets(*filled);
    const SurfaceReport state = check_surface(*filled, contact_);
    const std::size_t still_open = count_of(state, DefectKind::open_edge);
    if (still_open >= open)
      return log(RepairStep::fill, false,
                 fmt::format("{} of {} open edges would be left", still_open, open));
    double area = 0, reach = 0;
    for (std::size_t f = 0; f < filled->triangles.size(); ++f) {
      const double distance = locator_->nearest(filled->centroid(f)).distance;
      if (distance <= contact_) continue;
      area += filled->area_vector(f).norm();
      reach = std::max(reach, distance);
    }
    const double share = area / area_of(*filled);
    log(RepairStep::fill, true,
        fmt::format(
            "{} closed; the patches are {:.2g} % of the surface and reach {} from the rest{}",
            counted(counts.empty() ? 0 : at(counts[0]), "hole", "holes"), 100 * share,
            length(reach), sheets_left_out(counts)));
    report_.patch_area = area;
    carry_groups(mesh_, SurfaceLocator(mesh_), contact_, *filled);
    accept(std::move(*filled), state);
    orient_outward(mesh_);
    state_ = check_surface(mesh_, contact_);
    // What the patches enclose is the part now; the later steps are measured against it.
    original_ = mesh_;
    locator_.emplace(original_);
    if (!report_.volume_before) report_.volume_before = enclosed_volume(original_);
  }

  void unite() {
    if (has(state_, DefectKind::open_edge)) return;
    std::vector<std::int64_t> counts;
    std::optional<SurfaceMesh> united = ask_helper(RepairStep::unite, {}, &counts);
    if (!united) return;
    const SurfaceReport state = check_surface(*united, contact_);
    if (!state.sound() || state.bodies() >= std::max(2, state_.bodies() + (state_.sound() ? 0 : 1)))
      return log(RepairStep::unite, false,
                 !state.sound()   ? "the union would still not bound a solid"
                 : state_.sound() ? "the bodies do not touch one another"
                                  : fmt::format("{} bodies apart would be left", state.bodies()));
    const Change moved = change(*united);
    if (!moved.refusal.empty()) return log(RepairStep::unite, false, moved.refusal);
    log(RepairStep::unite, true,
        fmt::format("{} of facets became {}{}", counted(state_.shells.size(), "shell", "shells"),
                    counted(state.shells.size(), "shell", "shells"), sheets_left_out(counts)));
    report_.distance = std::max(report_.distance, moved.distance);
    carry_groups(mesh_, *locator_, contact_, *united);
    accept(std::move(*united), state);
  }

  // Screws and motors that a housing was exported with; whoever means one of them says so.
  void drop() {
    if (!state_.sound()) return;
    const std::vector<Body> bodies = find_bodies(mesh_, state_.shells);
    const auto largest =
        std::max_element(bodies.begin(), bodies.end(),
                         [](const Body& a, const Body& b) { return a.volume < b.volume; });
    double whole = 0;
    for (const Body& body : bodies) whole += body.volume;
    const double rest = 1 - largest->volume / whole;
    if (rest > options_.limit)
      return log(
          RepairStep::drop, false,
          fmt::format("the largest of {} bodies has only {:.2g} % of the volume; the limit is "
                      "{:.2g} %",
                      bodies.size(), 100 * (1 - rest), 100 * (1 - options_.limit)));
    log(RepairStep::drop, true,
        fmt::format("{} that touch nothing left out, {:.2g} % of the volume",
                    counted(bodies.size() - 1, "body", "bodies"), 100 * rest));
    keep_body(mesh_, *largest);
    state_ = check_surface(mesh_, contact_);
  }

  // From coarse to fine: the first that stays within the limit. Where the volume does not come
  // nearer, a finer one would not help.
  void wrap() {
    std::string last;
    double volume = std::numeric_limits<double>::infinity();
    constexpr double finest = 280;
    for (const double fineness : {40.0, 80.0, 140.0, finest}) {
      const double alpha = diagonal_ / fineness, offset = alpha / 30;
      std::optional<SurfaceMesh> wrapped = ask_helper(RepairStep::wrap, {alpha, offset});
      if (!wrapped) return;
      const SurfaceReport state = shrink(*wrapped, offset);
      if (!state.sound()) {
        last = "the wrapped surface does not bound a solid";
        continue;
      }
      if (state.bodies() > 1)
        return log(RepairStep::wrap, false,
                   fmt::format("{} bodies would be left, for they are apart", state.bodies()));
      const Change moved = change(*wrapped);
      last = moved.refusal;
      if (!report_.volume_before && !moved.refusal.empty()) break;
      const double finer = finest / fineness;
      if (moved.volume > std::min(0.8 * volume, finer * finer * options_.limit)) break;
      volume = moved.volume > 0 ? moved.volume : volume;
      if (!moved.refusal.empty()) continue;
      log(RepairStep::wrap, true,
          fmt::format("balls of radius {} rolled over the surface: {} instead of {}", length(alpha),
                      counted(wrapped->triangles.size(), "facet", "facets"),
                      mesh_.triangles.size()));
      report_.distance = std::max(report_.distance, moved.distance);
      carry_groups(mesh_, *locator_, 2 * offset, *wrapped);
      return accept(std::move(*wrapped), state);
    }
    log(RepairStep::wrap, false, last);
  }
  // Wrapping keeps a distance from the surface; most of it is taken back, so that flat faces are
  // where they were, as far as that leaves a sound surface. What becomes thin by it is cleaned
  // away.
  SurfaceReport shrink(SurfaceMesh& wrapped, double offset) const {
    const std::vector<Vector3> far = wrapped.points;
    std::vector<Vector3> near;
    near.reserve(far.size());
    for (const Vector3& p : far) near.push_back(locator_->nearest(p).point);
    SurfaceReport state;
    for (const double rest : {0.1, 0.4, 1.0}) {
      for (std::size_t i = 0; i < far.size(); ++i)
        wrapped.points[i] = near[i] + rest * (far[i] - near[i]);
      state = check_surface(wrapped, contact_);
      if (state.sound()) break;
    }
    const std::vector<int> no_tags(wrapped.triangles.size(), 0);
    if (auto clean = without_thin_facets(wrapped, no_tags, 0.1 * offset)) {
      wrapped = std::move(clean->mesh);
      state = check_surface(wrapped, contact_);
    }
    return state;
  }

  // Of a new surface beside the original one.
  struct Change {
    std::string refusal = {};  // why it is too large, empty when it is not
    double distance = 0;       // [m]
    double volume = 0;         // of the volume, as a fraction; 0 where it is not known
  };

  Change change(const SurfaceMesh& mesh) const {
    Change change{.distance = farthest_distance(mesh, *locator_, 0.01 * diagonal_)};
    const std::optional<double> volume = enclosed_volume(mesh);
    const double ratio = area_of(mesh) / area_of(original_);
    const bool encloses = report_.volume_before && volume;
    const double growth = encloses ? *volume / *report_.volume_before - 1 : 0;
    if (encloses) change.volume = std::abs(growth);
    if (report_.volume_before && is_nothing(*report_.volume_before))
      change.refusal = "the surface encloses nothing";
    else if (change.distance > options_.limit * diagonal_)
      change.refusal = fmt::format(
          "the surface would move by {}, {:.2g} % of the diagonal; the limit is {:.2g} %",
          length(change.distance), 100 * change.distance / diagonal_, 100 * options_.limit);
    else if (!(change.volume <= options_.limit))
      change.refusal = fmt::format("the volume would change by {:+.2g} %; the limit is {:.2g} %",
                                   100 * growth, 100 * options_.limit);
    else if (!encloses && ratio > 1.5)
      change.refusal = fmt::format(
          "the surface is open, and would be wrapped from both sides ({:.2g} times the area)",
          ratio);
    return change;
  }

  bool is_nothing(double volume) const {
    // Of a cube it would be 0.07.
    return std::abs(volume) < 1e-9 * std::pow(area_of(original_), 1.5);
  }

  void accept(SurfaceMesh mesh, const SurfaceReport& state) {
    mesh_ = std::move(mesh);
    state_ = state;
  }

  SurfaceMesh& mesh_;
  const RepairOptions& options_;
  common::Progress& progress_;
  double diagonal_, contact_, length_;
  SurfaceReport state_;
  SurfaceMesh original_;
  std::optional<SurfaceLocator> locator_;  // of original_
  RepairReport report_;
};

}  // namespace

const std::vector<std::string>& repair_steps() {
  static const std::vector<std::string> names{"weld", "orient", "fill", "unite", "drop", "wrap"};
  return names;
}

std::string name(RepairStep step) { return repair_steps()[static_cast<std::size_t>(step)]; }

RepairStep repair_step(const std::string& name) {
  const auto& names = repair_steps();
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end())
    throw std::invalid_argument(fmt::format("'{}' is no step of repair", name));
  return static_cast<RepairStep>(found - names.begin());
}

RepairReport repair(SurfaceMesh& mesh, const RepairOptions& options, common::Progress& progress) {
  if (!(options.tolerance >= 0) || !(options.limit >= 0) || !(options.time_limit > 0))
    throw std::invalid_argument("repair: tolerance, limit or time limit out of bounds");
  return Repair(mesh, options, progress).run();
}

std::vector<std::string> describe(const RepairReport& report, const RepairOptions& options) {
  std::vector<std::string> lines;
  for (const RepairAction& action : report.actions)
    lines.push_back(fmt::format("repair, {}: {}{}", name(action.step),
                                action.done ? "" : "not done, ", action.words));
  const bool changed = std::any_of(report.actions.begin(), report.actions.end(),
                                   [](const RepairAction& action) { return action.done; });
  if (!changed) return lines;
  const double unit = spatial::parse_quantity("1 " + options.unit, spatial::dimension::length);
  const std::string volume =
      report.volume_before ? fmt::format("the enclosed volume changed by {:+.2g} %",
                                         100 * (report.volume_after / *report.volume_before - 1))
                           : "the volume enclosed before is not known, for the surface was open";
  lines.push_back(fmt::format("repair as a whole: {}, the surface moved by {:.3g} {} at most",
                              volume, report.distance / unit, options.unit));
  return lines;
}

}  // namespace kinetostat::fea
