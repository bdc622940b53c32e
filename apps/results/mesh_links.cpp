#include "kinetostat/apps/results/mesh_links.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <variant>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/common/error.h"
#include "kinetostat/common/printable.h"
#include "kinetostat/fea/interface/joint_interface.h"
#include "kinetostat/fea/link/identify.h"
#include "kinetostat/fea/link/link_file.h"
#include "kinetostat/fea/mesh/edge_division.h"
#include "kinetostat/fea/mesh/primitive_surface.h"
#include "kinetostat/fea/mesh/surface_import.h"
#include "kinetostat/fea/surface/one_solid.h"
#include "kinetostat/fea/surface/surface_distance.h"
#include "kinetostat/io/cache.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/io/yaml.h"
#include "kinetostat/report/links/link_result.h"
#include "kinetostat/spatial/rotation.h"

namespace kinetostat::apps::mesh_links {
namespace {

namespace fs = std::filesystem;
using fea::JointAxis;
using fea::JointInterface;
using fea::SurfaceMesh;
using spatial::Matrix3;
using spatial::Vector3;

std::string millimetres(const Vector3& v) {
  const auto figure = [](double x) { return std::abs(x) < 1e-12 ? 0.0 : 1e3 * x; };
  return fmt::format("[{:.9g}, {:.9g}, {:.9g}]", figure(v.x()), figure(v.y()), figure(v.z()));
}
std::string direction(const Vector3& v) {
  const auto figure = [](double x) { return std::abs(x) < 1e-9 ? 0.0 : x; };
  return fmt::format("[{:.12g}, {:.12g}, {:.12g}]", figure(v.x()), figure(v.y()), figure(v.z()));
}

// As link files write it, without its braces.
std::string selector_text(const fea::Selector& selector) {
  if (const auto* cylinder = std::get_if<fea::CylinderSelector>(&selector))
    return fmt::format("cylinder: {{axis_point: {}, axis: {}, radius: {:.9g}, length: {:.9g}}}",
                       millimetres(cylinder->axis_point), direction(cylinder->axis),
                       1e3 * cylinder->radius, 1e3 * *cylinder->length);
  if (const auto* plane = std::get_if<fea::PlaneSelector>(&selector))
    return fmt::format("plane: {{point: {}, normal: {}}}", millimetres(plane->point),
                       direction(plane->normal));
  if (const auto* box = std::get_if<fea::BoxSelector>(&selector))
    return fmt::format("box: {{min: {}, max: {}}}", millimetres(box->box.min()),
                       millimetres(box->box.max()));
  const auto& ray = std::get<fea::NearestFaceSelector>(selector);
  return fmt::format("nearest_face: {{point: {}, direction: {}}}", millimetres(ray.point),
                     direction(ray.direction));
}

std::string file_name(const std::string& body) {
  std::string name = body;
  for (char& c : name)
    if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '-') c = '_';
  return name;
}

constexpr double stored_unit = 1e-3;  // [m] of the meshes beside the robot file

SurfaceMesh primitive_surface(const vjm::PrimitiveSolid& solid) {
  using Kind = vjm::PrimitiveSolid::Kind;
  if (solid.kind == Kind::box) return fea::box_surface(-solid.edges / 2, solid.edges / 2);
  return solid.kind == Kind::cylinder ? fea::cylinder_surface(solid.radius, solid.length)
                                      : fea::capsule_surface(solid.radius, solid.length);
}

// The shape in the frame of the body, as the file will hold it.
SurfaceMesh placed(SurfaceMesh surface, const vjm::DescribedShape& shape) {
  for (Vector3& point : surface.points) {
    point = shape.pose * shape.scale.cwiseProduct(point) / stored_unit;
    point = stored_unit * point.cast<float>().cast<double>();
  }
  if (shape.scale.prod() < 0)
    for (fea::Triangle& triangle : surface.triangles) std::swap(triangle[0], triangle[1]);
  return surface;
}

// The same surface with facets small enough that some lie near a joint anywhere on it.
SurfaceMesh divided(const SurfaceMesh& surface) {
  constexpr double longest = 1.0 / 20;  // edge, of the diagonal
  return fea::halve_edges(surface, longest * fea::bounding_box(surface.points).diagonal().norm());
}

// Why a body keeps being rigid.
struct Refusal {
  std::string reason;
};

// A mesh in millimetres whose description does not say so is a thousand times as large as its
// robot.
void require_size_of(const vjm::RobotDescription& robot, const SurfaceMesh& surface) {
  constexpr double too_large = 50;
  double reach = 0;
  for (const vjm::DescribedJoint& joint : robot.joints) reach += joint.origin.position().norm();
  const double size = fea::bounding_box(surface.points).diagonal().norm();
  if (reach > 0 && size > too_large * reach)
    throw Refusal{fmt::format(
        "is {:.3g} m across, and all joints together {:.3g} m apart: a mesh in millimetres needs a "
        "scale of 0.001 in the description",
        size, reach)};
}

// One in metres that is scaled as if it were in millimetres is a thousandth of it.
void require_size_of(const vjm::ImportedBody& body, const SurfaceMesh& surface) {
  constexpr double too_small = 1.0 / 50;
  const double size = fea::bounding_box(surface.points).diagonal().norm(),
               way = body.end.position().norm();
  if (size < too_small * way)
    throw Refusal{fmt::format(
        "is {:.4g} mm across, and its joints {:.6g} mm apart: its unit, or its scale in the "
        "description, is probably wrong",
        1e3 * size, 1e3 * way)};
}

// The parts of a body together, to look at or for collisions.
using Shapes = std::vector<vjm::DescribedShape>;

// "arm.dae and 2 more"
std::string names(const Shapes& shapes) {
  const std::string first = shapes.front().name();
  return shapes.size() == 1 ? first : fmt::format("{} and {} more", first, shapes.size() - 1);
}

// "its mesh repaired (fill, unite); the largest of 3 bodies in it, 95 % of their volume"
std::string words_of(const Shapes& shapes, const fea::OneSolid& solid) {
  std::vector<std::string> parts, steps;
  if (std::any_of(shapes.begin(), shapes.end(), [](const auto& s) { return s.file.empty(); }))
    parts.push_back(fmt::format("its shape is {}, no finer than the description", names(shapes)));
  for (const fea::RepairStep step : solid.repairs) steps.push_back(fea::name(step));
  if (!steps.empty())
    parts.push_back(fmt::format("its mesh repaired ({})", fmt::join(steps, ", ")));
  if (solid.bodies > 1)
    parts.push_back(fmt::format("the largest of {} bodies in the mesh, {:.2g} % of their volume",
                                solid.bodies, 100 * solid.share));
  return fmt::format("{}", fmt::join(parts, "; "));
}

class BodyStudy {
 public:
  BodyStudy(const vjm::RobotDescription& robot, const vjm::ImportedBody& body,
            const MeshLinkRequest& request, Run& run)
      : robot_(robot),
        body_(body),
        request_(request),
        run_(run),
        folder_(request.robot_file.parent_path() / (request.robot_file.stem().string() + "_links")),
        stem_(file_name(body.name)) {}

  // Fills `links` of the body, or throws a Refusal.
  void run(MeshLinks& links) {
    if (body_.shapes.empty()) throw Refusal{"the description gives it no shape"};
    std::string reasons;
    // Shapes that have faces for the joints before those that have none.
    for (const bool faces : {true, false}) {
      reasons.clear();
      for (const Shapes& shapes : both_kinds()) try {
          identify(shapes, faces);
          if (!reasons.empty()) words_ += "; instead of " + reasons;
          links.links[body_.name] = entry();
          links.words.push_back(words_);
          return;
        } catch (const Refusal& refusal) {
          reasons +=
              fmt::format("{}{}: {}", reasons.empty() ? "" : "; ", names(shapes), refusal.reason);
        }
    }
    throw Refusal{reasons};
  }

 private:
  // Those to look at first.
  std::vector<Shapes> both_kinds() const {
    Shapes seen, collision;
    for (const vjm::DescribedShape& shape : body_.shapes)
      (shape.is_collision ? collision : seen).push_back(shape);
    std::vector<Shapes> kinds;
    if (!seen.empty()) kinds.push_back(std::move(seen));
    if (!collision.empty()) kinds.push_back(std::move(collision));
    return kinds;
  }

  SurfaceMesh surface_of(const Shapes& shapes) const {
    SurfaceMesh all;
    for (const vjm::DescribedShape& shape : shapes) {
      if (shape.file.empty()) {
        fea::append(all, placed(primitive_surface(shape.solid), shape));
        continue;
      }
      const fs::path file = mesh_file(shape.file, robot_.file, request_.packages);
      if (file.empty())
        throw Refusal{"its package is not known, name it with --package NAME=FOLDER"};
      if (!fs::exists(file)) throw Refusal{fmt::format("there is no file {}", file.string())};
      fea::append(all, placed(fea::read_surface(file, "m").mesh, shape));
    }
    require_size_of(robot_, all);
    require_size_of(body_, all);
    return all;
  }

  // How far the nearest of a face is from the frame of its joint.
  static double gap(const SurfaceMesh& surface, const JointInterface& face, const Vector3& frame) {
    const fea::SurfaceLocator locator(surface);
    double least = std::numeric_limits<double>::infinity();
    for (const int facet : face.facets) least = std::min(least, locator.distance(frame, facet));
    return least;
  }

  // A shape that ends far from a joint: what is between is as if rigid.
  void warn_of_gap(const SurfaceMesh& surface, double gap, const char* frame) {
    constexpr double fair_share = 0.25;  // of what the link is across
    if (gap < fair_share * fea::bounding_box(surface.points).diagonal().norm()) return;
    const std::string words = fmt::format(
        "its shape ends {:.4g} mm from {}, and what is between is taken for rigid: check the unit "
        "and the scale of the shape, and whether parts of it are missing",
        1e3 * gap, frame);
    run_.warn(fmt::format("{}: {}.", body_.name, words));
    words_ += "; " + words;
  }

  void say_faces(const SurfaceMesh& surface, const JointInterface& held,
                 const JointInterface& loaded) {
    const double before = gap(surface, held, Vector3::Zero()),
                 behind = gap(surface, loaded, body_.end.position());
    words_ = fmt::format("{}: held at the {}, loaded at the {}", body_.name,
                         place(held, "its joint's frame", before),
                         place(loaded, body_.end_axis ? "that of the next" : "the tip", behind));
    warn_of_gap(surface, before, "its joint's frame");
    warn_of_gap(surface, behind, body_.end_axis ? "the frame of the next joint" : "the tip");
  }

  void identify(const Shapes& shapes, bool faces) {
    try {
      const fea::OneSolid& solid = solid_of(shapes);
      const SurfaceMesh surface = faces ? solid.surface : divided(solid.surface);
      const auto [held, loaded] = interfaces(surface, faces);
      fs::create_directories(folder_);
      io::write_atomically(folder_ / (stem_ + ".stl"), fea::stl_bytes(surface, stored_unit));
      const fea::LinkResult result = solved(names(shapes), held, loaded);
      io::write_json(folder_ / (stem_ + ".link.json"), report::to_json(result));
      say_faces(surface, held, loaded);
      describe(result, words_of(shapes, solid));
    } catch (const common::InputError& error) {
      throw Refusal{error.details().what};
    } catch (const common::NoConvergence& error) {
      throw Refusal{error.what()};
    }
  }

  const fea::OneSolid& solid_of(const Shapes& shapes) {
    const bool kind = shapes.front().is_collision;
    if (!solids_.contains(kind))
      solids_.emplace(
          kind, fea::one_solid(surface_of(shapes), {.limit = 0.02, .stored_unit = stored_unit},
                               run_.progress()));
    const std::optional<fea::OneSolid>& solid = solids_.at(kind);
    if (!solid) throw Refusal{"bounds no solid, not even repaired"};
    return *solid;
  }

  // Faces about the axes alone, or else what lies around the frames of the joints.
  std::pair<JointInterface, JointInterface> interfaces(const SurfaceMesh& surface,
                                                       bool faces) const {
    const JointAxis start{Vector3::Zero(), body_.start_axis};
    std::vector<JointInterface> before = fea::joint_interfaces(surface, start);
    std::vector<JointInterface> behind = ends(surface);
    if (!faces) {
      append(before, fea::surroundings(surface, start));
      append(behind, fea::surroundings(surface, end_axes().front()));
    }
    if (before.empty())
      throw Refusal{"no face about the axis of the joint that carries it, and nothing near it"};
    if (behind.empty())
      throw Refusal{body_.end_axis
                        ? "no face about the axis of the joint that it carries, and nothing near it"
                        : "no face at the tip, and nothing near it"};
    const auto both = fea::apart(surface, before, behind);
    if (!both) throw Refusal{"its joints share the only faces about their axes"};
    return *both;
  }

  // That of the next joint; at the tip any axis of its frame.
  std::vector<JointAxis> end_axes() const {
    const Vector3& point = body_.end.position();
    if (body_.end_axis) return {{point, *body_.end_axis}};
    const Matrix3& tip = body_.end.rotation();
    return {{point, tip.col(2)}, {point, tip.col(0)}, {point, tip.col(1)}};
  }

  std::vector<JointInterface> ends(const SurfaceMesh& surface) const {
    std::vector<JointInterface> all;
    for (const JointAxis& axis : end_axes()) append(all, fea::joint_interfaces(surface, axis));
    std::stable_sort(all.begin(), all.end(), [](const JointInterface& a, const JointInterface& b) {
      return a.rank < b.rank;
    });
    return all;
  }

  static void append(std::vector<JointInterface>& all, const std::vector<JointInterface>& more) {
    all.insert(all.end(), more.begin(), more.end());
  }

  std::string link_file(const std::string& mesh, const JointInterface& held,
                        const JointInterface& loaded) const {
    return fmt::format(
        "# Made by 'kinetostat import' of {}, in the frame behind the joint that carries it.\n"
        "kinetostat: 1\nlink: {}\nmesh: {{file: {}.stl, unit: mm}}\nmaterial: {}\n"
        "fixed: {{{}}}   # {}\nloaded: {{{}, point: {}}}   # {}\nelements: {{accuracy: {}}}\n",
        common::printable(mesh), io::yaml_scalar(body_.name), stem_, request_.material,
        selector_text(held.selector), held.words, selector_text(loaded.selector),
        millimetres(body_.end.position()), loaded.words, request_.accuracy);
  }

  fea::LinkResult solved(const std::string& mesh, const JointInterface& held,
                         const JointInterface& loaded) const {
    const fs::path file = folder_ / (stem_ + ".yaml");
    io::write_atomically(file, link_file(mesh, held, loaded));
    const fea::LinkSpec spec = fea::read_link(file);
    const fea::LinkGeometry geometry = fea::read_geometry(spec, run_.progress());
    const io::Cache cache = request_.no_cache ? io::Cache() : io::Cache::of_user();
    fea::IdentifyOptions options;
    options.meshing.cache = &cache;
    options.solver.threads = run_.threads();
    options.refinement.time_limit = 120;
    options.refinement.most_unknowns = 300'000;
    return fea::identify(spec, geometry, options, run_.progress());
  }

  // "bore of radius 20 mm, 3.5 mm from its joint's frame"; to a hundredth.
  static std::string place(const JointInterface& face, std::string_view frame, double gap) {
    const auto hundredths = [](double metres) { return std::round(1e5 * metres) / 100; };
    if (const auto* cube = std::get_if<fea::BoxSelector>(&face.selector)) {
      const double half = cube->box.sizes().x() / 2;
      const bool is_around = gap < std::sqrt(3.0) * half;
      return fmt::format("{}{} {} mm {} {}, as no face lies about that axis", face.words,
                         is_around ? " within" : ",", hundredths(is_around ? half : gap),
                         is_around ? "of" : "from", frame);
    }
    return fmt::format("{}, {} mm from {}", face.words, hundredths(std::abs(face.off)), frame);
  }

  void describe(const fea::LinkResult& result, const std::string& mesh) {
    if (!mesh.empty()) words_ += "; " + mesh;
    if (!result.accuracy.shortfall.empty())
      words_ +=
          fmt::format("; error bars of {:.2g} %, {}", 100 * result.accuracy.bars.relative_error,
                      result.accuracy.meshes.size() > 1
                          ? "more than was asked"
                          : "which no second mesh confirms, for it would be too large");
    if (!result.mass || !(body_.mass > 0) || !(*result.mass > 1.5 * body_.mass)) return;
    const double left = body_.mass / *result.mass, of_rod = 1 - (1 - left) * (1 - left);
    words_ += fmt::format(
        "; solid it would weigh {:.3g} kg, not {:.3g} kg: the link is hollow and softer than this, "
        "as a tube of that weight has {:.2g} % of the bending stiffness of a rod as thick",
        *result.mass, body_.mass, 100 * of_rod);
  }

  // The lines of the link in the robot file.
  std::string entry() const {
    const std::string folder = folder_.filename().string();
    std::string text = fmt::format("compliance: {}\nlink_file: {}\n",
                                   io::yaml_scalar(fmt::format("{}/{}.link.json", folder, stem_)),
                                   io::yaml_scalar(fmt::format("{}/{}.yaml", folder, stem_)));
    const Vector3 turn = spatial::log_rotation(body_.end.rotation());
    if (turn.norm() > 1e-14)
      text += fmt::format("end_axes: {{rotation_vector: [{:.15g}, {:.15g}, {:.15g}]}}\n", turn.x(),
                          turn.y(), turn.z());
    return text;
  }

  const vjm::RobotDescription& robot_;
  const vjm::ImportedBody& body_;
  const MeshLinkRequest& request_;
  Run& run_;
  fs::path folder_;
  std::string stem_, words_;
  std::map<bool, std::optional<fea::OneSolid>> solids_;  // to look at, for collisions
};

}  // namespace
}  // namespace kinetostat::apps::mesh_links

namespace kinetostat::apps {
namespace {

// Before the first link is looked at.
template <class Parse>
void require_readable(const char* option, const std::string& text, const Parse& parse) try {
  (void)parse(text);
} catch (const common::InputError& error) {
  throw UsageError(option, error.details().what, error.details().cure);
}

}  // namespace

std::string link_material(const std::string& text) {
  if (text == "steel") return "{E: 210 GPa, nu: 0.3, density: 7850 kg/m^3}";
  if (text == "aluminium") return "{E: 70 GPa, nu: 0.33, density: 2700 kg/m^3}";
  if (text == "cast-iron") return "{E: 110 GPa, nu: 0.26, density: 7200 kg/m^3}";
  if (!text.starts_with('{'))
    throw UsageError("--material", fmt::format("'{}' is no material that is known", text),
                     "Give steel, aluminium, cast-iron, or '{E: 70 GPa, nu: 0.33}'");
  require_readable("--material", text, fea::parse_material);
  return text;
}

std::string link_accuracy(const std::string& text) {
  const bool is_plain = text.find_first_not_of("0123456789.") == std::string::npos;
  const std::string accuracy = is_plain ? text + " %" : text;
  require_readable("--accuracy", accuracy, fea::parse_accuracy);
  return accuracy;
}

std::filesystem::path mesh_file(const std::string& name, const std::filesystem::path& description,
                                const Packages& packages) {
  namespace fs = std::filesystem;
  if (name.starts_with("file://")) return name.substr(7);
  for (const char* scheme : {"package://", "model://"}) {
    if (!name.starts_with(scheme)) continue;
    const std::string rest = name.substr(std::string(scheme).size());
    const std::size_t slash = rest.find('/');
    if (slash == std::string::npos) return {};
    const std::string package = rest.substr(0, slash), inside = rest.substr(slash + 1);
    for (const auto& [known, folder] : packages)
      if (known == package) return folder / inside;
    // As in ROS: the folder of the package has its name.
    for (fs::path folder = fs::absolute(description).parent_path(); folder.has_relative_path();
         folder = folder.parent_path())
      if (folder.filename() == package) return folder / inside;
    return {};
  }
  return description.parent_path() / name;
}

MeshLinks identify_bodies(const vjm::RobotDescription& robot,
                          const std::vector<vjm::ImportedBody>& bodies,
                          const MeshLinkRequest& request, Run& run) {
  MeshLinks links;
  for (const vjm::ImportedBody& body : bodies) try {
      mesh_links::BodyStudy(robot, body, request, run).run(links);
    } catch (const mesh_links::Refusal& refusal) {
      links.reasons[body.name] = refusal.reason;
    }
  return links;
}

}  // namespace kinetostat::apps
