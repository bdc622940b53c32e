#include "kinetostat/apps/commands/mesh_links.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include <fmt/format.h>

#include "kinetostat/common/printable.h"
#include "kinetostat/fea/interface/joint_interface.h"
#include "kinetostat/fea/link/identify.h"
#include "kinetostat/fea/mesh/surface_import.h"
#include "kinetostat/fea/surface/surface_bodies.h"
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

// The mesh in metres in the frame of the body.
SurfaceMesh placed(const fs::path& file, const vjm::DescribedMesh& mesh) {
  SurfaceMesh surface = fea::read_surface(file, "m").mesh;
  for (Vector3& point : surface.points) point = mesh.pose * mesh.scale.cwiseProduct(point);
  if (mesh.scale.prod() < 0)
    for (fea::Triangle& triangle : surface.triangles) std::swap(triangle[0], triangle[1]);
  return surface;
}

// Leaves the largest of several bodies; how many there were.
std::size_t keep_largest(SurfaceMesh& surface) {
  const fea::SurfaceReport report =
      fea::check_surface(surface, fea::weld_tolerance(surface.points));
  const std::vector<fea::Body> bodies = fea::find_bodies(surface, report.shells);
  const auto largest =
      std::max_element(bodies.begin(), bodies.end(), [](const fea::Body& a, const fea::Body& b) {
        return std::abs(a.volume) < std::abs(b.volume);
      });
  if (bodies.size() > 1) fea::keep_body(surface, *largest);
  fea::drop_unused_points(surface);
  return bodies.size();
}

// Why a body keeps being rigid.
struct Refusal {
  std::string reason;
};

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
    if (body_.meshes.empty()) throw Refusal{"the description names no mesh"};
    std::string reasons;
    for (const vjm::DescribedMesh& mesh : body_.meshes) try {
        identify(mesh);
        links.links[body_.name] = entry();
        links.words.push_back(words_);
        return;
      } catch (const Refusal& refusal) {
        reasons += fmt::format("{}{}: {}", reasons.empty() ? "" : "; ",
                               fs::path(mesh.file).filename().string(), refusal.reason);
      }
    throw Refusal{reasons};
  }

 private:
  void identify(const vjm::DescribedMesh& mesh) {
    const fs::path file = mesh_file(mesh.file, robot_.file, request_.packages);
    if (file.empty())
      throw Refusal{fmt::format("its package is not known, name it with --package NAME=FOLDER")};
    if (!fs::exists(file)) throw Refusal{fmt::format("there is no file {}", file.string())};
    try {
      SurfaceMesh surface = placed(file, mesh);
      const std::size_t bodies = keep_largest(surface);
      const auto [held, loaded] = interfaces(surface);
      fs::create_directories(folder_);
      io::write_atomically(folder_ / (stem_ + ".stl"), fea::stl_bytes(surface, 1e-3));
      const fea::LinkResult result = solved(mesh.file, held, loaded);
      io::write_json(folder_ / (stem_ + ".link.json"), report::to_json(result));
      describe(result, held, loaded, bodies);
    } catch (const common::InputError& error) {
      throw Refusal{error.details().what};
    } catch (const common::NoConvergence& error) {
      throw Refusal{error.what()};
    }
  }

  std::pair<JointInterface, JointInterface> interfaces(const SurfaceMesh& surface) const {
    const std::vector<JointInterface> before =
        fea::joint_interfaces(surface, JointAxis{Vector3::Zero(), body_.start_axis});
    if (before.empty()) throw Refusal{"no face about the axis of the joint that carries it"};
    const std::vector<JointInterface> behind = ends(surface);
    if (behind.empty())
      throw Refusal{body_.end_axis ? "no face about the axis of the joint that it carries"
                                   : "no face at the tip"};
    const auto both = fea::apart(surface, before, behind);
    if (!both) throw Refusal{"its joints share the only faces about their axes"};
    return *both;
  }

  // About the axis of the next joint; at the tip about any axis of its frame.
  std::vector<JointInterface> ends(const SurfaceMesh& surface) const {
    const Vector3& point = body_.end.position();
    if (body_.end_axis) return fea::joint_interfaces(surface, {point, *body_.end_axis});
    std::vector<JointInterface> all;
    for (const int axis : {2, 0, 1}) {
      const std::vector<JointInterface> some =
          fea::joint_interfaces(surface, {point, body_.end.rotation().col(axis)});
      all.insert(all.end(), some.begin(), some.end());
    }
    std::stable_sort(all.begin(), all.end(), [](const JointInterface& a, const JointInterface& b) {
      return a.rank < b.rank;
    });
    return all;
  }

  std::string link_file(const std::string& mesh, const JointInterface& held,
                        const JointInterface& loaded, bool repaired) const {
    return fmt::format(
        "# Made by 'kinetostat import' of {}, in the frame behind the joint that carries it.\n"
        "kinetostat: 1\nlink: {}\nmesh: {{file: {}.stl, unit: mm{}}}\nmaterial: {}\n"
        "fixed: {{{}}}   # {}\nloaded: {{{}, point: {}}}   # {}\nelements: {{accuracy: {}}}\n",
        common::printable(mesh), io::yaml_scalar(body_.name), stem_,
        repaired ? ", repair: [weld, orient, fill]" : "", request_.material,
        selector_text(held.selector), held.words, selector_text(loaded.selector),
        millimetres(body_.end.position()), loaded.words, request_.accuracy);
  }

  // As it is, else repaired.
  fea::LinkResult solved(const std::string& mesh, const JointInterface& held,
                         const JointInterface& loaded) const {
    const fs::path file = folder_ / (stem_ + ".yaml");
    for (const bool repaired : {false, true}) {
      io::write_atomically(file, link_file(mesh, held, loaded, repaired));
      const fea::LinkSpec spec = fea::read_link(file);
      try {
        return solve(spec, fea::read_geometry(spec, run_.progress()));
      } catch (const fea::SurfaceError&) {
        if (repaired) throw;
      }
    }
    throw std::logic_error("a link is solved or refused");
  }

  fea::LinkResult solve(const fea::LinkSpec& spec, const fea::LinkGeometry& geometry) const {
    const io::Cache cache = request_.no_cache ? io::Cache() : io::Cache::of_user();
    fea::IdentifyOptions options;
    options.meshing.cache = &cache;
    options.solver.threads = run_.threads();
    options.refinement.time_limit = 120;
    options.refinement.most_unknowns = 300'000;
    return fea::identify(spec, geometry, options, run_.progress());
  }

  // To a hundredth.
  static double off_in_mm(const JointInterface& face) {
    return std::round(1e5 * std::abs(face.off)) / 100;
  }

  void describe(const fea::LinkResult& result, const JointInterface& held,
                const JointInterface& loaded, std::size_t bodies) {
    words_ = fmt::format(
        "{}: held at the {}, {} mm from its joint's frame, loaded at the {}, {} mm from {}",
        body_.name, held.words, off_in_mm(held), loaded.words, off_in_mm(loaded),
        body_.end_axis ? "that of the next" : "the tip");
    if (bodies > 1) words_ += fmt::format("; the largest of {} bodies in the mesh", bodies);
    if (!result.accuracy.shortfall.empty()) words_ += "; " + result.accuracy.shortfall;
    if (result.mass && body_.mass > 0 && *result.mass > 1.5 * body_.mass)
      words_ += fmt::format(
          "; solid it would weigh {:.3g} kg, not {:.3g} kg: the link is hollow and softer than "
          "this",
          *result.mass, body_.mass);
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
};

}  // namespace
}  // namespace kinetostat::apps::mesh_links

namespace kinetostat::apps {

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
