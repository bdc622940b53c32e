#include "kinetostat/fea/mesh/surface_import.h"

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <cstring>
#include <new>
#include <sstream>
#include <string_view>

#include <assimp/Importer.hpp>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include "kinetostat/common/byte_blocks.h"
#include "kinetostat/common/child_process.h"
#include "kinetostat/common/error.h"
#include "kinetostat/common/memory.h"
#include "kinetostat/common/out_of_memory.h"
#include "kinetostat/fea/mesh/length_unit.h"
#include "kinetostat/fea/mesh/volume_mesh.h"
#include "kinetostat/fea/surface/step_program.h"
#include "kinetostat/io/text_file.h"

namespace kinetostat::fea {
namespace {

using common::InputError;

constexpr std::size_t stl_header = 84, stl_facet = 50;

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
  // Not binary then. Editors put a byte-order sign before the text and zeros after it.
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
  return common::encode_blocks(soup.names, soup.facets_of_name, soup.coordinates);
}

bool decode(const std::string& bytes, Soup& soup) {
  return common::decode_blocks(bytes, soup.names, soup.facets_of_name, soup.coordinates);
}

// Throws with a reason.
std::string triangle_soup(const std::string& bytes, const std::string& kind) {
  Assimp::Importer importer;
  unsigned steps = aiProcess_Triangulate;
  if (kind == "dae") {
    // The nodes of the file place its meshes and give the unit; its axes stay, as in ROS.
    importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
    steps |= aiProcess_PreTransformVertices;
  }
  const aiScene* scene =
      importer.ReadFileFromMemory(bytes.data(), bytes.size(), steps, kind.c_str());
  if (scene == nullptr) {
    const std::string said = importer.GetErrorString();
    if (said.find("bad_alloc") != std::string::npos) throw std::bad_alloc();
    throw std::runtime_error(said);
  }
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

void check_step(const std::filesystem::path& file, const std::string& bytes) {
  if (bytes.substr(0, 1000).find("ISO-10303-21") == std::string::npos)
    throw InputError(file, "not a STEP file: it does not start with 'ISO-10303-21'",
                     "Export the link again, as STEP AP214 or as STL");
}

common::OutOfMemory too_large(const std::filesystem::path& file) {
  return {"reading it takes more memory than there is",
          "Close other programs, or export a coarser mesh", file.string()};
}

// The importer takes some ten times what the file has, unless its counts are damaged.
bool is_enough_to_read(std::size_t file_size) {
  const double needed = 32 * static_cast<double>(file_size) + (64 << 20);
  return needed < std::min(common::address_space_left(), 8.0 * (1 << 30));
}

InputError refused_step(const std::filesystem::path& file, const StepError& error) {
  switch (error.cause()) {
    case StepError::Cause::no_helper:
      return {file, fmt::format("STEP files cannot be read here: {}", error.what()),
              "Install it, or export the link as STL"};
    case StepError::Cause::timed_out:
      return {file, error.what(), "Export the link without small details, or as STL"};
    default:
      return {file, fmt::format("not a readable STEP file: {}", error.what()),
              "Export the link again, as STEP AP214 or as STL"};
  }
}

SurfaceMesh import_step(const std::filesystem::path& file, const std::string& bytes,
                        const StepFacets& facets) {
  check_step(file, bytes);
  common::Progress progress;
  try {
    return step_surface(bytes, facets, {}, progress);
  } catch (const StepError& error) {
    if (error.cause() == StepError::Cause::out_of_memory) throw too_large(file);
    throw refused_step(file, error);
  }
}

SurfaceMesh import_triangles(const std::filesystem::path& file, std::string bytes,
                             const StepFacets& facets) {
  const std::string kind = lower_extension(file);
  if (kind == "geo")
    throw InputError(
        file, "a script of gmsh is no surface, and may do anything that a program may",
        fmt::format("If you trust it, run 'gmsh -2 {0}.geo -o {0}.stl' and name the STL "
                    "file",
                    file.stem().string()));
  if (!is_step(kind) && kind != "stl" && kind != "obj" && kind != "ply" && kind != "dae" &&
      kind != "msh")
    throw InputError(file,
                     kind.empty()
                         ? "a file without an extension does not say its format"
                         : fmt::format("'.{}' is not a surface format that is read here", kind),
                     "Export the link as STL, OBJ, PLY, DAE or STEP");
  if (bytes.empty()) throw InputError(file, "the file is empty", "Export the mesh again");
  refuse_placeholder(file, bytes);
  if (is_step(kind)) return import_step(file, bytes, facets);
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
  const common::ChildResult result =
      common::run_isolated([&] { return triangle_soup(bytes, kind); }, time_limit);
  if (result.ran_out_of_memory() && !is_enough_to_read(bytes.size())) throw too_large(file);
  if (result.end != common::ChildResult::End::exited || result.code != 0)
    throw InputError(
        file,
        fmt::format("not a readable {} file: {}", kind,
                    result.end == common::ChildResult::End::timed_out ? "reading never ends"
                    : result.words.empty()                            ? "reading it fails"
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

std::string unit_of_format(const std::filesystem::path& file) {
  const std::string kind = lower_extension(file);
  if (kind == "dae") return "m";
  return is_step(kind) ? "mm" : "";
}

ImportedSurface read_surface(const std::filesystem::path& file, const std::string& unit,
                             const StepFacets& facets) {
  const std::string bytes = io::read_text(file);
  SurfaceMesh mesh = import_triangles(file, bytes, facets);
  check_coordinates(file, mesh);
  if (!is_step(lower_extension(file))) {
    const std::string known = unit_of_format(file);
    const double scale = metres_per_unit(file, known.empty() ? unit : known, mesh.points);
    for (Vector3& p : mesh.points) p *= scale;
  }
  const WeldReport report = weld(mesh, weld_tolerance(mesh.points));
  if (mesh.triangles.empty())
    throw InputError(file, "all facets collapse to points or lines", "Export the mesh again");
  return {std::move(mesh), report, io::sha256(bytes),
          is_step(lower_extension(file)) ? bytes : std::string()};
}

}  // namespace kinetostat::fea
