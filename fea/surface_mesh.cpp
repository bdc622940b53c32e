#include "kinetostat/fea/surface_mesh.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <numeric>
#include <sstream>
#include <string_view>
#include <unordered_map>

#include <assimp/Importer.hpp>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include "kinetostat/fea/byte_blocks.h"
#include "kinetostat/fea/child_process.h"
#include "kinetostat/fea/gmsh_program.h"
#include "kinetostat/fea/volume_mesh.h"
#include "kinetostat/files/error.h"
#include "kinetostat/files/text_file.h"
#include "kinetostat/spatial/units.h"

namespace kinetostat::fea {
namespace {

using files::InputError;

constexpr std::size_t stl_header = 84, stl_facet = 50;

// Cubic cells as wide as the tolerance: a point's partners lie in its cell or the 26 around it.
class PointGrid {
 public:
  PointGrid(const Vector3& origin, double width) : origin_(origin), width_(width) {}

  // The kept point that `point` becomes, or -1.
  int find(const Vector3& point, const std::vector<Vector3>& kept) const {
    const Cell centre = cell(point);
    int best = -1;
    for (int dx = -1; dx <= 1; ++dx)
      for (int dy = -1; dy <= 1; ++dy)
        for (int dz = -1; dz <= 1; ++dz) {
          const auto entry = cells_.find({centre[0] + dx, centre[1] + dy, centre[2] + dz});
          if (entry == cells_.end()) continue;
          for (const int candidate : entry->second)
            if ((kept[static_cast<std::size_t>(candidate)] - point).norm() <= width_ &&
                (best < 0 || candidate < best))
              best = candidate;
        }
    return best;
  }
  void add(const Vector3& point, int index) { cells_[cell(point)].push_back(index); }

 private:
  using Cell = std::array<std::int64_t, 3>;
  struct Hash {
    std::size_t operator()(const Cell& c) const {
      std::uint64_t h = 0;
      for (const std::int64_t k : c)
        h = (h ^ static_cast<std::uint64_t>(k)) * 0x9E3779B97F4A7C15u + (h >> 29);
      return h ^ h >> 32;
    }
  };
  Cell cell(const Vector3& p) const {
    const Vector3 scaled = (p - origin_) / width_;
    return {std::llround(scaled.x()), std::llround(scaled.y()), std::llround(scaled.z())};
  }

  Vector3 origin_;
  double width_;
  std::unordered_map<Cell, std::vector<int>, Hash> cells_;
};

// Numbers identical points alike; `points` shrinks to one of each, in order of first appearance.
std::vector<int> merge_identical(std::vector<Vector3>& points) {
  std::vector<int> order(points.size());
  std::iota(order.begin(), order.end(), 0);
  const auto key = [&points](int i) {
    const Vector3& p = points[static_cast<std::size_t>(i)];
    return std::array<double, 3>{p.x(), p.y(), p.z()};
  };
  std::sort(order.begin(), order.end(), [&key](int a, int b) {
    const auto ka = key(a), kb = key(b);
    return ka != kb ? ka < kb : a < b;
  });
  std::vector<int> first(points.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool same = i > 0 && key(order[i]) == key(order[i - 1]);
    first[static_cast<std::size_t>(order[i])] =
        same ? first[static_cast<std::size_t>(order[i - 1])] : order[i];
  }
  std::vector<int> number(points.size());
  std::vector<Vector3> kept;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (first[i] == static_cast<int>(i)) {
      number[i] = static_cast<int>(kept.size());
      kept.push_back(points[i]);
    } else {
      number[i] = number[static_cast<std::size_t>(first[i])];
    }
  }
  points = std::move(kept);
  return number;
}

std::string lower_case(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

std::string lower_extension(const std::filesystem::path& file) {
  const std::string extension = lower_case(file.extension().string());
  return extension.empty() ? extension : extension.substr(1);
}

// The rest of the line after "solid" is a name and may say anything.
struct StlWords {
  std::size_t facets = 0, facet_ends = 0;
  bool ends = false;
};

StlWords count_words(const std::string& text) {
  StlWords count;
  std::string_view rest = text;
  while (!rest.empty()) {
    const std::string_view line = rest.substr(0, rest.find_first_of("\r\n"));
    rest.remove_prefix(std::min(line.size() + 1, rest.size()));
    const std::size_t begin = line.find_first_not_of(" \t");
    if (begin == std::string_view::npos) continue;
    const std::string_view word = line.substr(begin, line.find_first_of(" \t", begin) - begin);
    if (word == "facet") ++count.facets;
    if (word == "endfacet") ++count.facet_ends;
    if (word == "endsolid") count.ends = true;
  }
  return count;
}

void check_ascii_stl(const std::filesystem::path& file, const std::string& lower_case_text) {
  const StlWords count = count_words(lower_case_text);
  if (count.facets != count.facet_ends || !count.ends)
    throw InputError(
        file,
        fmt::format("this ASCII STL is cut short: {} facets start, {} end{}", count.facets,
                    count.facet_ends, count.ends ? "" : ", no 'endsolid'"),
        "Export the mesh again");
}

// The importer wants names short, and words in lower case; groups keep the case of their names.
std::string tidied(const std::string& text, const std::string& lower_case_text) {
  constexpr std::size_t longest = 200;
  std::string result;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find_first_of("\r\n", begin), text.size());
    const std::size_t word = std::min(text.find_first_not_of(" \t", begin), end);
    const bool is_name = lower_case_text.compare(word, 5, "solid") == 0;
    if (is_name)
      result += "solid" + text.substr(word + 5, std::min(end - word - 5, longest));
    else
      result.append(lower_case_text, begin, end - begin);
    result += '\n';
    begin = end + 1;
  }
  return result;
}

bool is_text(const std::string& bytes) {
  const std::size_t seen = std::min<std::size_t>(bytes.size(), 1000);
  return std::all_of(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(seen), [](char c) {
    const auto byte = static_cast<unsigned char>(c);
    return byte >= ' ' || byte == '\t' || byte == '\r' || byte == '\n';
  });
}

// Repositories of robot descriptions keep meshes apart from their texts; a copy may lack them.
void refuse_placeholder(const std::filesystem::path& file, const std::string& bytes) {
  if (bytes.starts_with("version https://git-lfs"))
    throw InputError(file, "this is not the mesh but the note that Git LFS leaves in its place",
                     "Fetch the mesh with 'git lfs pull'");
}

[[noreturn]] void refuse_text(const std::filesystem::path& file, const std::string& bytes) {
  throw InputError(
      file,
      fmt::format("this is text, but no ASCII STL: it starts with '{}', not with "
                  "'solid'",
                  bytes.substr(0, std::min<std::size_t>(bytes.find_first_of("\r\n"), 40))),
      "Export the mesh as STL");
}

// The importer trusts the facet count of a binary STL and stops silently at the end of an ASCII
// one.
void check_stl(const std::filesystem::path& file, std::string& bytes) {
  std::uint32_t count = 0;
  if (bytes.size() >= stl_header) std::memcpy(&count, bytes.data() + 80, sizeof count);
  const std::size_t expected = stl_header + stl_facet * std::size_t{count};
  if (bytes.size() >= stl_header && bytes.size() == expected) return;
  // Not binary then. Editors put a byte-order mark before the text and zero bytes after it.
  const bool has_mark = bytes.starts_with("\xef\xbb\xbf");
  const std::size_t first = bytes.find_first_not_of(" \t\r\n", has_mark ? 3 : 0);
  const std::size_t last = bytes.find_last_not_of(std::string_view(" \t\r\n\0", 5));
  if (first != std::string::npos && last != std::string::npos) {
    const std::string text = bytes.substr(first, last + 1 - first);
    const std::string lower = lower_case(text);
    if (lower.starts_with("solid") && text.find('\0') == std::string::npos) {
      check_ascii_stl(file, lower);
      bytes = tidied(text, lower);
      return;
    }
    if (is_text(text)) refuse_text(file, text);
  }
  if (bytes.size() < stl_header)
    throw InputError(file, fmt::format("{} bytes are too few for an STL file", bytes.size()),
                     "Export the mesh again");
  throw InputError(file,
                   fmt::format("the binary STL header announces {} facets ({} bytes), the file has "
                               "{} bytes",
                               count, expected, bytes.size()),
                   bytes.size() < expected ? "The file is cut short: export the mesh again"
                                           : "Is this an STL file? Export the mesh again");
}

// The importer believes the counts of a PLY header and works for hours on a huge one. It also finds
// counts in damaged lines; so no number of the header may exceed the number of bytes after it.
void check_ply(const std::filesystem::path& file, const std::string& bytes) {
  const std::size_t header_end = bytes.find("end_header");
  if (bytes.compare(0, 3, "ply") != 0 || header_end == std::string::npos)
    throw InputError(file, "not a PLY file: no header", "Export the mesh again");
  std::istringstream header(bytes.substr(0, header_end));
  for (std::string line; std::getline(header, line);) {
    if (line.starts_with("comment ") || line.starts_with("obj_info ")) continue;
    double count = 0;
    for (const char c : line) {
      count = std::isdigit(static_cast<unsigned char>(c)) ? 10 * count + (c - '0') : 0;
      if (count > static_cast<double>(bytes.size() - header_end))
        throw InputError(file,
                         fmt::format("the header announces more than the {} bytes after it hold",
                                     bytes.size() - header_end),
                         "The file is cut short or damaged: export the mesh again");
    }
  }
}

// Names of the meshes of a scene: their own, else those of the nodes that hold them.
std::vector<std::string> mesh_names(const aiScene& scene) {
  std::vector<std::string> names(scene.mNumMeshes);
  for (unsigned m = 0; m < scene.mNumMeshes; ++m) names[m] = scene.mMeshes[m]->mName.C_Str();
  std::vector<const aiNode*> open{scene.mRootNode};
  while (!open.empty()) {
    const aiNode* node = open.back();
    open.pop_back();
    if (node == nullptr) continue;
    for (unsigned i = 0; i < node->mNumMeshes; ++i)
      if (std::string& name = names.at(node->mMeshes[i]); name.empty()) name = node->mName.C_Str();
    for (unsigned i = 0; i < node->mNumChildren; ++i) open.push_back(node->mChildren[i]);
  }
  return names;
}

// What the importer's process hands back: corners of all triangles, in the order of the file, and
// how many triangles go by which name.
struct Soup {
  std::string names;  // each ends with a zero byte
  std::vector<std::uint64_t> facets_of_name;
  std::vector<float> coordinates;
};

std::string encode(const Soup& soup) {
  return encode_blocks(soup.names, soup.facets_of_name, soup.coordinates);
}

bool decode(const std::string& bytes, Soup& soup) {
  return decode_blocks(bytes, soup.names, soup.facets_of_name, soup.coordinates);
}

// Throws with a reason.
std::string triangle_soup(const std::string& bytes, const std::string& kind) {
  Assimp::Importer importer;
  const aiScene* scene =
      importer.ReadFileFromMemory(bytes.data(), bytes.size(), aiProcess_Triangulate, kind.c_str());
  if (scene == nullptr) throw std::runtime_error(importer.GetErrorString());
  const std::vector<std::string> names = mesh_names(*scene);
  Soup soup;
  for (unsigned m = 0; m < scene->mNumMeshes; ++m) {
    const aiMesh& part = *scene->mMeshes[m];
    const std::size_t before = soup.coordinates.size();
    for (unsigned i = 0; i < part.mNumFaces; ++i) {
      const aiFace& face = part.mFaces[i];
      if (face.mNumIndices != 3) continue;  // loose points and lines of OBJ and PLY
      for (unsigned k = 0; k < 3; ++k) {
        if (face.mIndices[k] >= part.mNumVertices)
          throw std::runtime_error(fmt::format("facet {} names point {} of {}", i + 1,
                                               face.mIndices[k] + 1, part.mNumVertices));
        const aiVector3D& p = part.mVertices[face.mIndices[k]];
        soup.coordinates.insert(soup.coordinates.end(), {p.x, p.y, p.z});
      }
    }
    soup.names += names[m] + '\0';
    soup.facets_of_name.push_back((soup.coordinates.size() - before) / 9);
  }
  return encode(soup);
}

// Facets first to first + count belong to what has this name, too.
void add_to_group(SurfaceMesh& mesh, const std::string& name, std::size_t first,
                  std::size_t count) {
  if (name.empty() || count == 0) return;
  auto group = std::find_if(mesh.groups.begin(), mesh.groups.end(),
                            [&name](const FacetGroup& g) { return g.name == name; });
  if (group == mesh.groups.end()) group = mesh.groups.insert(group, {name, {}});
  for (std::size_t f = first; f < first + count; ++f) group->facets.push_back(static_cast<int>(f));
}

SurfaceMesh mesh_of(const Soup& soup) {
  SurfaceMesh mesh;
  for (std::size_t at = 0; at + 2 < soup.coordinates.size(); at += 3)
    mesh.points.emplace_back(soup.coordinates[at], soup.coordinates[at + 1],
                             soup.coordinates[at + 2]);
  for (int i = 0; i + 2 < static_cast<int>(mesh.points.size()); i += 3)
    mesh.triangles.push_back({i, i + 1, i + 2});
  std::size_t first = 0, name_begin = 0;
  for (const std::uint64_t count : soup.facets_of_name) {
    const std::string name = soup.names.c_str() + name_begin;
    name_begin += name.size() + 1;
    add_to_group(mesh, name, first, count);
    first += count;
  }
  return mesh;
}

bool is_step(const std::string& kind) { return kind == "step" || kind == "stp"; }

// gmsh takes other files for models too; only STEP models go to it.
void check_step(const std::filesystem::path& file, const std::string& bytes) {
  if (bytes.substr(0, 1000).find("ISO-10303-21") == std::string::npos)
    throw InputError(file, "not a STEP file: it does not start with 'ISO-10303-21'",
                     "Export the link again, as STEP AP214 or as STL");
}

SurfaceMesh import_step(const std::filesystem::path& file, const std::string& bytes) {
  check_step(file, bytes);
  if (find_gmsh().empty())
    throw InputError(file, "STEP files are read through the program gmsh, which is not installed",
                     "Install it (Debian: gmsh), or export the link as STL");
  files::Progress progress;
  try {
    SurfaceMesh mesh = triangles_of(parse_msh(file, step_surface(bytes, {}, progress)));
    mesh.groups.clear();  // numbers that only gmsh knows
    if (!mesh.triangles.empty()) return mesh;
  } catch (const GmshError& error) {
    throw InputError(file, fmt::format("not a readable STEP file: {}", error.what()),
                     "Export the link again, as STEP AP214 or as STL");
  }
  throw InputError(file, "the STEP file holds no surface", "Export the link as a solid");
}

SurfaceMesh import_triangles(const std::filesystem::path& file, std::string bytes) {
  const std::string kind = lower_extension(file);
  if (kind == "geo")
    throw InputError(
        file, "a script of gmsh is no surface, and may do anything that a program may",
        fmt::format("If you trust it, run 'gmsh -2 {0}.geo -o {0}.stl' and name the STL "
                    "file",
                    file.stem().string()));
  if (!is_step(kind) && kind != "stl" && kind != "obj" && kind != "ply" && kind != "msh")
    throw InputError(file,
                     kind.empty()
                         ? "a file without an extension does not say its format"
                         : fmt::format("'.{}' is not a surface format that is read here", kind),
                     "Export the link as STL, OBJ, PLY or STEP");
  if (bytes.empty()) throw InputError(file, "the file is empty", "Export the mesh again");
  refuse_placeholder(file, bytes);
  if (is_step(kind)) return import_step(file, bytes);
  if (kind == "msh") {
    SurfaceMesh mesh = triangles_of(parse_msh(file, bytes));
    if (mesh.triangles.empty())
      throw InputError(file, "the file holds no triangles", "Mesh the surface of the link");
    return mesh;
  }
  if (kind == "stl") check_stl(file, bytes);
  if (kind == "ply") check_ply(file, bytes);
  // The importer can crash or run for hours on a damaged file.
  const double time_limit = 5 + 2e-6 * static_cast<double>(bytes.size());
  const ChildResult result = run_isolated([&] { return triangle_soup(bytes, kind); }, time_limit);
  if (result.end != ChildResult::End::exited || result.code != 0)
    throw InputError(file,
                     fmt::format("not a readable {} file: {}", kind,
                                 result.end == ChildResult::End::timed_out ? "reading never ends"
                                 : result.words.empty()                    ? "reading it fails"
                                                                           : result.words),
                     "Export the mesh again");
  Soup soup;
  if (!decode(result.answer, soup))
    throw InputError(file, fmt::format("not a readable {} file: reading it fails", kind),
                     "Export the mesh again");
  SurfaceMesh mesh = mesh_of(soup);
  if (mesh.triangles.empty())
    throw InputError(file, "the file holds no triangles", "Export the surface of the link");
  return mesh;
}

void check_coordinates(const std::filesystem::path& file, const SurfaceMesh& mesh) {
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f)
    for (std::size_t k = 0; k < 3; ++k)
      if (!mesh.corner(f, k).allFinite())
        throw InputError(file, fmt::format("facet {} has a corner that is not finite", f + 1),
                         "Export the mesh again");
}

}  // namespace

Box bounding_box(const std::vector<Vector3>& points) {
  Box box;
  for (const Vector3& p : points) box.extend(p);
  return box;
}

double metres_per_unit(const std::filesystem::path& file, const std::string& unit,
                       const std::vector<Vector3>& points) {
  const Vector3 size = bounding_box(points).sizes();
  if (unit.empty())
    throw MissingUnit(
        file,
        fmt::format("the mesh has no unit of length; its bounding box would be "
                    "{0:.4g} x {1:.4g} x {2:.4g} m in mm, {3:.4g} x {4:.4g} x {5:.4g} "
                    "m in m, {6:.4g} x {7:.4g} x {8:.4g} m in inch",
                    size.x() * 1e-3, size.y() * 1e-3, size.z() * 1e-3, size.x(), size.y(), size.z(),
                    size.x() * 0.0254, size.y() * 0.0254, size.z() * 0.0254),
        "State the unit: mm, m or inch");
  try {
    return spatial::parse_quantity("1 " + unit, spatial::dimension::length);
  } catch (const std::invalid_argument& error) {
    throw InputError(file, fmt::format("unit '{}': {}", unit, error.what()),
                     "State a unit of length: mm, m or inch");
  }
}

// Moeller and Trumbore 1997, Journal of Graphics Tools 2:21.
double ray_hit(const SurfaceMesh& surface, std::size_t facet, const Vector3& from,
               const Vector3& direction) {
  const Vector3 &a = surface.corner(facet, 0), ab = surface.corner(facet, 1) - a,
                ac = surface.corner(facet, 2) - a, cross = direction.cross(ac);
  const double determinant = ab.dot(cross);
  const double miss = std::numeric_limits<double>::infinity();
  if (determinant == 0) return miss;
  const Vector3 arm = from - a;
  const double u = arm.dot(cross) / determinant;
  const double v = direction.dot(arm.cross(ab)) / determinant;
  if (u < 0 || v < 0 || u + v > 1) return miss;
  const double distance = ac.dot(arm.cross(ab)) / determinant;
  return distance > 0 ? distance : miss;
}

double weld_tolerance(const std::vector<Vector3>& points) {
  const Box box = bounding_box(points);
  const double farthest =
      std::max(box.min().cwiseAbs().maxCoeff(), box.max().cwiseAbs().maxCoeff());
  return std::max(1e-6 * box.diagonal().norm(),
                  4 * double{std::numeric_limits<float>::epsilon()} * farthest);
}

void drop_unused_points(SurfaceMesh& mesh) {
  std::vector<int> number(mesh.points.size(), -1);
  for (const Triangle& t : mesh.triangles)
    for (const int corner : t) number[static_cast<std::size_t>(corner)] = 0;
  std::size_t count = 0;
  for (std::size_t p = 0; p < number.size(); ++p) {
    if (number[p] < 0) continue;
    number[p] = static_cast<int>(count);
    mesh.points[count++] = mesh.points[p];
  }
  mesh.points.resize(count);
  for (Triangle& t : mesh.triangles)
    for (int& corner : t) corner = number[static_cast<std::size_t>(corner)];
}

void keep_facets(SurfaceMesh& mesh, const std::vector<int>& kept) {
  std::vector<Triangle> triangles;
  for (std::size_t f = 0; f < kept.size(); ++f)
    if (kept[f] >= 0) triangles.push_back(mesh.triangles[f]);
  mesh.triangles = std::move(triangles);
  for (FacetGroup& group : mesh.groups) {
    std::vector<int> facets;
    for (const int f : group.facets)
      if (kept[static_cast<std::size_t>(f)] >= 0)
        facets.push_back(kept[static_cast<std::size_t>(f)]);
    group.facets = std::move(facets);
  }
  std::erase_if(mesh.groups, [](const FacetGroup& group) { return group.facets.empty(); });
  drop_unused_points(mesh);
}

std::vector<int> merge_near(std::vector<Vector3>& points, double tolerance) {
  std::vector<int> number(points.size());
  std::vector<Vector3> kept;
  PointGrid grid(bounding_box(points).min(), tolerance);
  for (std::size_t i = 0; i < points.size(); ++i) {
    number[i] = grid.find(points[i], kept);
    if (number[i] >= 0) continue;
    number[i] = static_cast<int>(kept.size());
    grid.add(points[i], number[i]);
    kept.push_back(points[i]);
  }
  points = std::move(kept);
  return number;
}

WeldReport weld(SurfaceMesh& mesh, double tolerance) {
  WeldReport report{.tolerance = tolerance, .points_before = mesh.points.size()};
  const std::vector<int> identical = merge_identical(mesh.points);
  std::vector<int> near(mesh.points.size());
  std::iota(near.begin(), near.end(), 0);
  if (tolerance > 0) near = merge_near(mesh.points, tolerance);
  std::vector<int> kept(mesh.triangles.size(), -1);
  int count = 0;
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    Triangle& t = mesh.triangles[f];
    for (int& corner : t)
      corner = near[static_cast<std::size_t>(identical[static_cast<std::size_t>(corner)])];
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0])
      report.collapsed.push_back(static_cast<int>(f));
    else
      kept[f] = count++;
  }
  keep_facets(mesh, kept);
  report.points_after = mesh.points.size();
  return report;
}

std::string unit_of_format(const std::filesystem::path& file) {
  return is_step(lower_extension(file)) ? "mm" : "";
}

ImportedSurface read_surface(const std::filesystem::path& file, const std::string& unit) {
  const std::string bytes = files::read_text(file);
  SurfaceMesh mesh = import_triangles(file, bytes);
  check_coordinates(file, mesh);
  const std::string known = unit_of_format(file);
  const double scale = metres_per_unit(file, known.empty() ? unit : known, mesh.points);
  for (Vector3& p : mesh.points) p *= scale;
  const WeldReport report = weld(mesh, weld_tolerance(mesh.points));
  if (mesh.triangles.empty())
    throw InputError(file, "all facets collapse to points or lines", "Export the mesh again");
  return {std::move(mesh), report, files::sha256(bytes)};
}

std::string stl_bytes(const SurfaceMesh& mesh, double metres) {
  std::string bytes(stl_header, '\0');
  const std::string title = "written by kinetostat";
  std::copy(title.begin(), title.end(), bytes.begin());
  const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
  std::memcpy(bytes.data() + 80, &count, sizeof count);
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    std::array<float, 12> values{};
    const auto put = [&values](std::size_t at, const Vector3& v) {
      for (std::size_t d = 0; d < 3; ++d)
        values[at + d] = static_cast<float>(v[static_cast<Eigen::Index>(d)]);
    };
    put(0, mesh.area_vector(f).normalized());
    for (std::size_t k = 0; k < 3; ++k) put(3 + 3 * k, mesh.corner(f, k) / metres);
    bytes.append(reinterpret_cast<const char*>(values.data()), sizeof values);
    bytes.append(2, '\0');
  }
  return bytes;
}

}  // namespace kinetostat::fea
