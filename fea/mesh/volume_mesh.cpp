#include "kinetostat/fea/mesh/volume_mesh.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <future>
#include <numeric>
#include <optional>
#include <unordered_map>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/common/error.h"
#include "kinetostat/common/index.h"
#include "kinetostat/common/spelling.h"
#include "kinetostat/fea/mesh/length_unit.h"
#include "kinetostat/io/text_file.h"

namespace kinetostat::fea {
namespace {

using common::at;
using common::InputError;

bool is_inp(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension == ".inp";
}

FileMesh parse(const std::filesystem::path& file, const std::string& bytes) {
  return is_inp(file) ? parse_inp(file, bytes) : parse_msh(file, bytes);
}

// Refusals that name an element of the file.
class Complaint {
 public:
  explicit Complaint(const std::filesystem::path& file) : file_(file) {}
  [[noreturn]] void operator()(const FileTet& tet, const std::string& what,
                               const std::string& cure) const {
    InputError::Details details;
    details.file = file_;
    details.line = tet.line;
    details.what = fmt::format("element {} {}", tet.number, what);
    details.cure = cure;
    throw InputError(details);
  }

 private:
  const std::filesystem::path& file_;
};

std::array<Vector3, 4> corners_of(const FileMesh& file, const FileTet& tet) {
  return {file.points[at(tet.nodes[0])], file.points[at(tet.nodes[1])],
          file.points[at(tet.nodes[2])], file.points[at(tet.nodes[3])]};
}

double longest_edge(const std::array<Vector3, 4>& p) {
  double longest = 0;
  for (const auto& [a, b] : tet_edges) longest = std::max(longest, (p[at(a)] - p[at(b)]).norm());
  return longest;
}

void require_one_order(const FileMesh& file, const Complaint& complain) {
  for (const FileTet& tet : file.tets)
    if (tet.node_count != file.tets.front().node_count)
      complain(tet,
               fmt::format("has {} nodes, element {} has {}", tet.node_count,
                           file.tets.front().number, file.tets.front().node_count),
               "Give all elements the same order");
}

// A mirrored part has every element inside out.
void mirror(FileTet& tet) {
  std::swap(tet.nodes[1], tet.nodes[2]);
  std::swap(tet.nodes[4], tet.nodes[6]);  // middles of 01 and 20
  std::swap(tet.nodes[8], tet.nodes[9]);  // of 13 and 23
}

// True when all elements had to be mirrored.
void refuse_mixed(const FileMesh& file, std::size_t negative, const Complaint& complain) {
  for (const FileTet& tet : file.tets)
    if (volume(corners_of(file, tet)) < 0)
      complain(tet,
               fmt::format("is inside out: its volume is negative, as that of {} of {} elements",
                           negative, file.tets.size()),
               "Correct the order of its nodes, or mesh the part again");
}

bool orient_elements(FileMesh& file, const Complaint& complain) {
  std::size_t negative = 0;
  for (const FileTet& tet : file.tets) {
    const auto p = corners_of(file, tet);
    const double longest = longest_edge(p), v = volume(p);
    if (std::abs(v) <= 1e-9 * longest * longest * longest)
      complain(tet, "is flat: its four corners lie in a plane", "Mesh the part again");
    negative += v < 0 ? 1 : 0;
  }
  if (negative == 0) return false;
  if (negative == file.tets.size()) {
    for (FileTet& tet : file.tets) mirror(tet);
    return true;
  }
  refuse_mixed(file, negative, complain);
  return false;
}

// Nodes of the elements' corners get the first numbers, in the order of the file.
struct Numbering {
  std::vector<int> of_file_node;  // -1: not a corner
  std::vector<Vector3> points;
};

Numbering number_corners(const FileMesh& file) {
  std::vector<bool> is_corner(file.points.size(), false);
  for (const FileTet& tet : file.tets)
    for (std::size_t k = 0; k < 4; ++k) is_corner[at(tet.nodes[k])] = true;
  Numbering numbering{.of_file_node = std::vector<int>(file.points.size(), -1), .points = {}};
  for (std::size_t i = 0; i < is_corner.size(); ++i) {
    if (!is_corner[i]) continue;
    numbering.of_file_node[i] = static_cast<int>(numbering.points.size());
    numbering.points.push_back(file.points[i]);
  }
  return numbering;
}

// Sides that belong to one element only, seen from outside.
std::vector<BoundaryFace> outside(const FileMesh& file, const std::vector<FileTet>& tets,
                                  const Numbering& numbering, const Complaint& complain) {
  struct Use {
    Triangle key, face;
    int tet;
  };
  std::vector<Use> uses;
  uses.reserve(4 * tets.size());
  for (std::size_t e = 0; e < tets.size(); ++e)
    for (const auto& side : tet_sides) {
      Triangle face{};
      for (std::size_t k = 0; k < 3; ++k)
        face[k] = numbering.of_file_node[at(tets[e].nodes[at(side[k])])];
      uses.push_back({sorted(face), face, static_cast<int>(e)});
    }
  std::sort(uses.begin(), uses.end(), [](const Use& a, const Use& b) {
    return std::tie(a.key, a.tet) < std::tie(b.key, b.tet);
  });
  std::vector<Use> single;
  for (std::size_t i = 0; i < uses.size();) {
    std::size_t j = i + 1;
    while (j < uses.size() && uses[j].key == uses[i].key) ++j;
    if (j - i > 2)
      complain(
          file.tets[at(uses[i + 2].tet)],
          fmt::format("shares a side with more than one element, {} and {}",
                      file.tets[at(uses[i].tet)].number, file.tets[at(uses[i + 1].tet)].number),
          "Elements overlap: mesh the part again");
    if (j - i == 1) single.push_back(uses[i]);
    i = j;
  }
  std::vector<BoundaryFace> faces;
  faces.reserve(single.size());
  for (const Use& use : single)
    faces.push_back({.nodes = {use.face[0], use.face[1], use.face[2], -1, -1, -1}, .tag = 0});
  return faces;
}

// Where the file puts the middle of each edge [file's unit].
class MidNodes {
 public:
  MidNodes(const FileMesh& file, const Numbering& numbering, const Complaint& complain) {
    for (const FileTet& tet : file.tets)
      for (std::size_t e = 0; e < tet_edges.size(); ++e) {
        const auto [a, b] = tet_edges[e];
        const std::uint64_t key = edge_key(numbering.of_file_node[at(tet.nodes[at(a)])],
                                           numbering.of_file_node[at(tet.nodes[at(b)])]);
        const int node = tet.nodes[4 + e];
        const auto [entry, is_new] = node_of_.try_emplace(key, node);
        if (!is_new && entry->second != node)
          complain(tet, "has another mid node on an edge than its neighbour",
                   "Merge coinciding nodes, or mesh the part again");
      }
  }
  int operator()(int a, int b) const { return node_of_.at(edge_key(a, b)); }

 private:
  std::unordered_map<std::uint64_t, int> node_of_;
};

// Faces by their corners, to find those that a file's triangles name.
class FaceIndex {
 public:
  explicit FaceIndex(const std::vector<BoundaryFace>& faces) {
    for (std::size_t f = 0; f < faces.size(); ++f)
      entries_.push_back(
          {sorted({faces[f].nodes[0], faces[f].nodes[1], faces[f].nodes[2]}), static_cast<int>(f)});
    std::sort(entries_.begin(), entries_.end());
  }
  /// -1: no outside face.
  int find(const Triangle& corners) const {
    const Triangle key = sorted(corners);
    const auto found = std::lower_bound(entries_.begin(), entries_.end(), std::pair(key, -1));
    return found != entries_.end() && found->first == key ? found->second : -1;
  }

 private:
  std::vector<std::pair<Triangle, int>> entries_;
};

void sort_unique(std::vector<int>& numbers) {
  std::sort(numbers.begin(), numbers.end());
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
}

// The outside faces of the file's groups. A set of nodes stands for the faces whose corners are all
// in it, and whose mid nodes are when the set has any.
std::vector<FacetGroup> face_groups(const FileMesh& file, const Numbering& numbering,
                                    const TetMesh& mesh, const std::optional<MidNodes>& middles) {
  const FaceIndex index(mesh.boundary);
  const auto corner = [&](int node) { return numbering.of_file_node[at(node)]; };
  std::vector<FacetGroup> groups;
  for (const auto& [name, group] : file.groups) {
    std::vector<int> faces;
    const auto add = [&](const Triangle& file_nodes) {
      const int face =
          index.find({corner(file_nodes[0]), corner(file_nodes[1]), corner(file_nodes[2])});
      if (face >= 0) faces.push_back(face);
    };
    for (const int t : group.triangles) add(file.triangles[at(t)]);
    for (const auto& [tet, side] : group.sides) {
      const auto& [a, b, c] = tet_sides[at(side)];
      const std::array<int, 10>& nodes = file.tets[at(tet)].nodes;
      add({nodes[at(a)], nodes[at(b)], nodes[at(c)]});
    }
    if (!group.nodes.empty()) {
      std::vector<bool> in_set(file.points.size(), false), corner_in_set(mesh.nodes.size(), false);
      bool has_middles = false;
      for (const int node : group.nodes) {
        in_set[at(node)] = true;
        has_middles = has_middles || corner(node) < 0;
        if (corner(node) >= 0) corner_in_set[at(corner(node))] = true;
      }
      for (std::size_t f = 0; f < mesh.boundary.size(); ++f) {
        const std::array<int, 6>& n = mesh.boundary[f].nodes;
        bool inside = corner_in_set[at(n[0])] && corner_in_set[at(n[1])] && corner_in_set[at(n[2])];
        if (inside && middles && has_middles)
          for (std::size_t k = 0; k < 3; ++k)
            inside = inside && in_set[at((*middles)(n[k], n[(k + 1) % 3]))];
        if (inside) faces.push_back(static_cast<int>(f));
      }
    }
    sort_unique(faces);
    if (!faces.empty()) groups.push_back({name, std::move(faces)});
  }
  return groups;
}

std::vector<ElementGroup> element_groups(const FileMesh& file) {
  std::vector<ElementGroup> groups;
  for (const auto& [name, group] : file.groups) {
    if (group.tets.empty()) continue;
    groups.push_back({name, group.tets});
    sort_unique(groups.back().elements);
  }
  return groups;
}

[[noreturn]] void refuse_body(const FileMesh& file, const std::filesystem::path& path,
                              const std::string& body) {
  std::vector<std::string> names;
  for (const ElementGroup& group : element_groups(file)) names.push_back(group.name);
  const std::string near = common::nearest_spelling(body, names);
  throw InputError(path, fmt::format("the mesh has no group of elements '{}'", body),
                   names.empty()
                       ? "Name the volumes of the bodies when the mesh is made"
                       : fmt::format("{}The groups are {}",
                                     near.empty() ? "" : fmt::format("Did you mean '{}'? ", near),
                                     fmt::join(names, ", ")));
}

// Leaves the elements of one group; what other groups have of them stays in these.
void keep_body(FileMesh& file, const std::filesystem::path& path, const std::string& body) {
  const auto group = file.groups.find(body);
  if (group == file.groups.end() || group->second.tets.empty()) refuse_body(file, path, body);
  std::vector<int> kept = group->second.tets, number(file.tets.size(), -1);
  sort_unique(kept);
  std::vector<FileTet> tets;
  for (const int tet : kept) {
    number[at(tet)] = static_cast<int>(tets.size());
    tets.push_back(file.tets[at(tet)]);
  }
  file.tets = std::move(tets);
  for (auto& [name, other] : file.groups) {
    std::erase_if(other.tets, [&](int tet) { return number[at(tet)] < 0; });
    std::erase_if(other.sides, [&](const auto& side) { return number[at(side.first)] < 0; });
    for (int& tet : other.tets) tet = number[at(tet)];
    for (auto& [tet, side] : other.sides) tet = number[at(tet)];
  }
}

TetMesh linear_mesh(const FileMesh& file, const Numbering& numbering, const Complaint& complain) {
  TetMesh mesh;
  mesh.nodes = numbering.points;
  for (const FileTet& tet : file.tets)
    for (std::size_t k = 0; k < 4; ++k)
      mesh.connectivity.push_back(numbering.of_file_node[at(tet.nodes[k])]);
  mesh.boundary = outside(file, file.tets, numbering, complain);
  return mesh;
}

// Mid nodes go where the file has them.
TetMesh with_given_middles(const TetMesh& linear, const FileMesh& file, const MidNodes& middles) {
  TetMesh mesh = with_mid_nodes(linear);
  double off = 0;
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    const auto tet = mesh.element(e);
    for (std::size_t k = 0; k < tet_edges.size(); ++k) {
      const int a = tet[at(tet_edges[k][0])], b = tet[at(tet_edges[k][1])];
      Vector3& node = mesh.nodes[at(tet[4 + k])];
      const Vector3& given = file.points[at(middles(a, b))];
      const Vector3 middle = 0.5 * (mesh.nodes[at(a)] + mesh.nodes[at(b)]);
      off = std::max(off, (given - middle).norm() / (mesh.nodes[at(a)] - mesh.nodes[at(b)]).norm());
      node = given;
    }
  }
  mesh.curved = off > 1e-6;  // files are written with seven digits or more
  return mesh.curved ? mesh : with_mid_nodes(linear);
}

void require_regular(const TetMesh& mesh, const FileMesh& file, const Complaint& complain) {
  if (!mesh.curved) return;
  for (std::size_t e = 0; e < mesh.element_count(); ++e)
    if (!(least_jacobian(mesh, e) > 0))
      complain(file.tets[e], "is turned inside out by its mid nodes",
               "Mesh with straight edges, or finer at strongly curved faces");
}

SurfaceMesh surface_of(const TetMesh& mesh) {
  SurfaceMesh surface;
  surface.points = mesh.nodes;
  for (const BoundaryFace& face : mesh.boundary)
    surface.triangles.push_back({face.nodes[0], face.nodes[1], face.nodes[2]});
  return surface;
}

}  // namespace

bool holds_volume_mesh(const std::filesystem::path& file) {
  if (is_inp(file)) return true;
  std::string extension = file.extension().string();
  if (extension != ".msh" && extension != ".MSH") return false;
  return !parse_msh(file, io::read_text(file)).tets.empty();
}

SurfaceMesh triangles_of(const FileMesh& file) {
  SurfaceMesh mesh{.points = file.points, .triangles = file.triangles};
  for (const auto& [name, group] : file.groups)
    if (!group.triangles.empty()) mesh.groups.push_back({name, group.triangles});
  return mesh;
}

TetMesh tagged_volume(const FileMesh& file) {
  const std::filesystem::path name = "mesh";
  const Complaint complain(name);
  if (file.tets.empty()) throw InputError(name, "it holds no tetrahedra");
  FileMesh oriented = file;
  orient_elements(oriented, complain);
  const Numbering numbering = number_corners(oriented);
  TetMesh mesh = linear_mesh(oriented, numbering, complain);
  for (BoundaryFace& face : mesh.boundary) face.tag = -1;
  for (const FacetGroup& group : face_groups(oriented, numbering, mesh, {})) {
    if (!group.name.starts_with("surface ")) continue;
    for (const int f : group.facets) mesh.boundary[at(f)].tag = std::stoi(group.name.substr(8)) - 1;
  }
  if (std::any_of(mesh.boundary.begin(), mesh.boundary.end(),
                  [](const BoundaryFace& face) { return face.tag < 0; }))
    throw InputError(name, "it has faces that are not on the surface");
  return mesh;
}

ImportedVolume read_volume_mesh(const std::filesystem::path& path, const std::string& unit,
                                const std::string& body) {
  const std::string bytes = io::read_text(path);
  // Beside the parsing: for a large file it takes as long.
  std::future<std::string> hash =
      std::async(std::launch::async, [&bytes] { return io::sha256(bytes); });
  FileMesh file = parse(path, bytes);
  if (file.tets.empty())
    throw InputError(path, "the file holds no tetrahedra",
                     "Write the volume mesh too: elements C3D4 or C3D10");
  const double scale = metres_per_unit(path, unit, file.points);
  if (!body.empty()) keep_body(file, path, body);
  const Complaint complain(path);
  ImportedVolume result;
  require_one_order(file, complain);
  if (orient_elements(file, complain))
    result.warnings.emplace_back(
        "all elements of the mesh file are inside out, as of a mirrored part: they were mirrored");
  const Numbering numbering = number_corners(file);
  result.mesh = linear_mesh(file, numbering, complain);
  std::optional<MidNodes> middles;
  if (file.tets.front().node_count == 10) {
    middles.emplace(file, numbering, complain);
    result.mesh = with_given_middles(result.mesh, file, *middles);
    require_regular(result.mesh, file, complain);
  }
  for (Vector3& p : result.mesh.nodes) p *= scale;
  result.surface = surface_of(result.mesh);
  result.surface.groups = face_groups(file, numbering, result.mesh, middles);
  result.element_groups = element_groups(file);
  result.sha256 = hash.get();
  return result;
}

}  // namespace kinetostat::fea
