#include <algorithm>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <unordered_map>

#include <fmt/format.h>

#include "kinetostat/common/error.h"
#include "kinetostat/common/index.h"
#include "kinetostat/fea/mesh/mesh_file.h"

namespace kinetostat::fea {
namespace {

using common::at;
using common::InputError;

// Numbers of a .msh file, one after the other, written out or as they lie in memory.
class Reader {
 public:
  Reader(const std::filesystem::path& file, const std::string& bytes) : file_(file), text_(bytes) {}

  bool binary = false;

  [[noreturn]] void fail(const std::string& what,
                         const std::string& cure = "Export the mesh again") const {
    InputError::Details details;
    details.file = file_;
    details.line = binary ? 0 : line_;
    details.what = what;
    details.cure = cure;
    throw InputError(details);
  }
  int line() const { return binary ? 0 : line_; }
  bool at_end() {
    skip_space();
    return at_ == text_.size();
  }
  bool next_is(char c) {
    skip_space();
    return at_ < text_.size() && text_[at_] == c;
  }

  std::string word(const char* what) {
    skip_space();
    const std::size_t begin = at_;
    while (at_ < text_.size() && !is_space(text_[at_])) ++at_;
    if (begin == at_) fail(fmt::format("the file ends where {} should be", what));
    return text_.substr(begin, at_ - begin);
  }
  std::string quoted(const char* what) {
    skip_space();
    const std::size_t end =
        at_ < text_.size() && text_[at_] == '"' ? text_.find('"', at_ + 1) : std::string::npos;
    if (end == std::string::npos) fail(fmt::format("{} in quotation marks is expected", what));
    std::string name = text_.substr(at_ + 1, end - at_ - 1);
    at_ = end + 1;
    return name;
  }
  void rest_of_line() {
    while (at_ < text_.size() && text_[at_] != '\n') ++at_;
    if (at_ < text_.size()) ++at_, ++line_;
  }
  void section(const std::string& name) {
    const bool numbers = binary;
    binary = false;  // the words around binary numbers are text
    const std::string found = word(("'" + name + "'").c_str());
    if (found != name) fail(fmt::format("'{}' is expected, not '{}'", name, found.substr(0, 30)));
    binary = numbers;
  }
  void skip_section(const std::string& name) {
    const std::size_t end = text_.find("$End" + name, at_);
    if (end == std::string::npos) fail(fmt::format("the section ${} does not end", name));
    line_ += static_cast<int>(std::count(text_.begin() + static_cast<std::ptrdiff_t>(at_),
                                         text_.begin() + static_cast<std::ptrdiff_t>(end), '\n'));
    at_ = end + name.size() + 4;
  }

  std::int64_t integer32(const char* what) { return number<std::int32_t>(what); }
  std::int64_t integer64(const char* what) { return number<std::int64_t>(what); }
  double real(const char* what) { return number<double>(what); }
  /// How many of something follow; no more than there are bytes for.
  std::size_t count(const char* what, bool wide = true) {
    const std::int64_t n = wide ? integer64(what) : integer32(what);
    if (n < 0 || at(n) > text_.size() - at_)
      fail(fmt::format("{} {} do not fit into the {} bytes that follow", n, what,
                       text_.size() - at_),
           "The file is cut short or damaged: export the mesh again");
    return at(n);
  }

 private:
  static bool is_space(char c) { return c == ' ' || c == '\n' || c == '\t' || c == '\r'; }
  void skip_space() {
    for (; at_ < text_.size() && is_space(text_[at_]); ++at_)
      if (text_[at_] == '\n') ++line_;
  }

  template <class Number>
  Number number(const char* what) {
    Number value{};
    if (binary) {
      if (text_.size() - at_ < sizeof value) fail(fmt::format("the file ends in its {}", what));
      std::memcpy(&value, text_.data() + at_, sizeof value);
      at_ += sizeof value;
      return value;
    }
    const std::string text = word(what);
    const char* begin = text.data() + (text.front() == '+' ? 1 : 0);
    const auto [end, error] = std::from_chars(begin, text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size())
      fail(fmt::format("'{}' is not a number, in the {}", text.substr(0, 30), what));
    return value;
  }

  const std::filesystem::path& file_;
  const std::string& text_;
  std::size_t at_ = 0;
  int line_ = 1;
};

enum : int { triangle3 = 2, tetra4 = 4, triangle6 = 9, tetra10 = 11 };

// Nodes of an element of each type of Gmsh, 0 where it is not known here.
int nodes_of_type(std::int64_t type) {
  constexpr std::array<int, 32> nodes{0, 2,  3,  4,  4, 8,  6,  5,  3,  6,  9, 10, 27, 18, 14, 1,
                                      8, 20, 15, 13, 9, 10, 12, 15, 15, 21, 4, 5,  6,  20, 35, 56};
  return type > 0 && type < static_cast<std::int64_t>(nodes.size()) ? nodes[at(type)] : 0;
}

// Solid elements of other shapes or orders.
bool is_other_solid(std::int64_t type) {
  constexpr std::array<int, 13> solids{5, 6, 7, 12, 13, 14, 17, 18, 19, 29, 30, 31, 92};
  return std::find(solids.begin(), solids.end(), type) != solids.end();
}

class MshFile {
 public:
  MshFile(const std::filesystem::path& file, const std::string& bytes) : in_(file, bytes) {}

  FileMesh parse() && {
    read_format();
    while (!in_.at_end()) read_section();
    return std::move(mesh_);
  }

 private:
  using Entity = std::pair<int, std::int64_t>;  // dimension, number

  void read_format() {
    in_.section("$MeshFormat");
    version_ = in_.word("the version of the format");
    const std::string kind = in_.word("the kind of file"), size = in_.word("the data size");
    if (version_ != "2.2" && version_ != "4.1" && version_ != "2")
      in_.fail(
          fmt::format("this is .msh format '{}'; 2.2 and 4.1 are read", version_.substr(0, 30)),
          "Save it again with 'gmsh FILE -save -format msh41'");
    if (size != "8" || (kind != "0" && kind != "1"))
      in_.fail(
          fmt::format("kind '{}' and data size '{}' are not those of a .msh file", kind, size));
    if (kind == "1") {
      in_.rest_of_line();
      in_.binary = true;
      if (in_.integer32("byte order") != 1)
        in_.fail("the numbers of this binary file are in the byte order of another computer",
                 "Save it as ASCII");
    }
    in_.section("$EndMeshFormat");
  }

  void read_section() {
    const bool numbers = in_.binary;
    in_.binary = false;
    std::string name = in_.word("a section");
    if (name.size() < 2 || name[0] != '$')
      in_.fail(fmt::format("a section such as '$Nodes' is expected, not '{}'", name.substr(0, 30)));
    name.erase(0, 1);
    const bool is_old = version_ != "4.1";
    if (name == "PhysicalNames") {
      read_names();
    } else if (name == "Entities" || name == "Nodes" || name == "Elements") {
      if (numbers && !is_old) in_.rest_of_line();
      if (name == "Entities") {
        in_.binary = numbers;
        read_entities();
      } else if (is_old) {
        const std::size_t count = in_.count(name.c_str());  // written out, also in a binary file
        if (numbers) in_.rest_of_line();
        in_.binary = numbers;
        name == "Nodes" ? read_old_nodes(count) : read_old_elements(count);
      } else {
        in_.binary = numbers;
        name == "Nodes" ? read_nodes() : read_elements();
      }
    } else {
      in_.skip_section(name);
      in_.binary = numbers;
      return;
    }
    in_.binary = numbers;
    in_.section("$End" + name);
  }

  void read_names() {
    const std::size_t count = in_.count("physical names");
    for (std::size_t i = 0; i < count; ++i) {
      const auto dimension = static_cast<int>(in_.integer32("dimension"));
      const std::int64_t number = in_.integer32("physical number");
      names_[{dimension, number}] = in_.quoted("the name of a physical group");
    }
  }

  // Which physical groups each entity belongs to.
  void read_entities() {
    std::array<std::size_t, 4> counts{};
    for (std::size_t& count : counts) count = in_.count("entities");
    for (int dimension = 0; dimension < 4; ++dimension)
      for (std::size_t i = 0; i < counts[at(dimension)]; ++i) {
        const std::int64_t tag = in_.integer32("entity");
        for (int k = 0; k < (dimension == 0 ? 3 : 6); ++k) in_.real("box of an entity");
        std::vector<std::int64_t>& groups = groups_of_[{dimension, tag}];
        for (std::size_t n = in_.count("physical groups"); n > 0; --n)
          groups.push_back(in_.integer32("physical group"));
        if (dimension == 0) continue;
        for (std::size_t n = in_.count("bounding entities"); n > 0; --n)
          in_.integer32("bounding entity");
      }
  }

  void add_node(std::int64_t number, const Vector3& point) {
    if (!point.allFinite()) in_.fail(fmt::format("node {} is not finite", number));
    if (!index_.emplace(number, static_cast<int>(mesh_.points.size())).second)
      in_.fail(fmt::format("node {} is there twice", number));
    mesh_.points.push_back(point);
  }
  Vector3 point() {
    const double x = in_.real("nodes"), y = in_.real("nodes"), z = in_.real("nodes");
    return {x, y, z};
  }

  void read_old_nodes(std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
      const std::int64_t number = in_.integer32("nodes");
      add_node(number, point());
    }
  }
  void read_nodes() {
    const std::size_t blocks = in_.count("blocks of nodes");
    in_.count("nodes");
    in_.integer64("lowest node"), in_.integer64("highest node");
    std::vector<std::int64_t> numbers;
    for (std::size_t b = 0; b < blocks; ++b) {
      const std::int64_t dimension = in_.integer32("dimension");
      in_.integer32("entity");
      const bool parametric = in_.integer32("parametric") != 0;
      numbers.resize(in_.count("nodes of a block"));
      for (std::int64_t& number : numbers) number = in_.integer64("nodes");
      for (const std::int64_t number : numbers) {
        add_node(number, point());
        for (std::int64_t k = 0; parametric && k < dimension; ++k) in_.real("parameters");
      }
    }
  }

  void read_old_elements(std::size_t count) {
    for (std::size_t done = 0; done < count;) {
      // ASCII: number type tags ...; binary: blocks of one type with a common header.
      std::int64_t number = in_.binary ? 0 : in_.integer32("elements");
      const std::int64_t type = in_.integer32("type of an element");
      const std::size_t block = in_.binary ? in_.count("elements of a block", false) : 1;
      const std::size_t tag_count = in_.count("tags of an element", false);
      for (std::size_t i = 0; i < block; ++i, ++done) {
        if (in_.binary) number = in_.integer32("elements");
        std::int64_t physical = 0;
        for (std::size_t k = 0; k < tag_count; ++k) {
          const std::int64_t tag = in_.integer32("tags of an element");
          if (k == 0) physical = tag;
        }
        read_element(type, number, {physical});
      }
      if (block == 0) ++done;
    }
  }
  void read_elements() {
    const std::size_t blocks = in_.count("blocks of elements");
    in_.count("elements");
    in_.integer64("lowest element"), in_.integer64("highest element");
    for (std::size_t b = 0; b < blocks; ++b) {
      const auto dimension = static_cast<int>(in_.integer32("dimension"));
      const std::int64_t entity = in_.integer32("entity");
      const std::int64_t type = in_.integer32("type of an element");
      const auto found = groups_of_.find({dimension, entity});
      const std::vector<std::int64_t> groups =
          found == groups_of_.end() ? std::vector<std::int64_t>{} : found->second;
      for (std::size_t n = in_.count("elements of a block"); n > 0; --n)
        read_element(type, in_.integer64("elements"), groups);
    }
  }

  void read_element(std::int64_t type, std::int64_t number,
                    const std::vector<std::int64_t>& groups) {
    const int line = in_.line();
    if (is_other_solid(type))
      in_.fail(
          fmt::format("element {} is of Gmsh's type {}; of solid elements only tetrahedra of 4 "
                      "and 10 nodes (types 4 and 11) are read",
                      number, type),
          "Mesh the part with tetrahedra of order 1 or 2");
    const int count = nodes_of_type(type);
    if (count == 0) in_.fail(fmt::format("element {} is of unknown type {}", number, type));
    std::array<int, 64> nodes{};
    for (int k = 0; k < count; ++k) nodes[at(k)] = node(number);
    if (type == triangle3 || type == triangle6) {
      for (const std::int64_t group : groups)
        if (group != 0)
          mesh_.groups[name_of(2, group)].triangles.push_back(
              static_cast<int>(mesh_.triangles.size()));
      mesh_.triangles.push_back({nodes[0], nodes[1], nodes[2]});
    } else if (type == tetra4 || type == tetra10) {
      for (const std::int64_t group : groups)
        if (group != 0)
          mesh_.groups[name_of(3, group)].tets.push_back(static_cast<int>(mesh_.tets.size()));
      FileTet tet{.node_count = count, .number = static_cast<int>(number), .line = line};
      std::copy_n(nodes.begin(), count, tet.nodes.begin());
      if (count == 10) std::swap(tet.nodes[8], tet.nodes[9]);  // Gmsh: ... 23 13
      mesh_.tets.push_back(tet);
    }
  }

  int node(std::int64_t element) {
    const std::int64_t number = version_ == "4.1" ? in_.integer64("nodes of an element")
                                                  : in_.integer32("nodes of an element");
    const auto found = index_.find(number);
    if (found == index_.end())
      in_.fail(fmt::format("element {} names node {}, which is not among the {} nodes", element,
                           number, mesh_.points.size()));
    return found->second;
  }

  std::string name_of(int dimension, std::int64_t group) const {
    const auto found = names_.find({dimension, group});
    return found != names_.end()
               ? found->second
               : fmt::format("{} {}", dimension == 2 ? "surface" : "volume", group);
  }

  Reader in_;
  std::string version_;
  FileMesh mesh_;
  std::unordered_map<std::int64_t, int> index_;
  std::map<Entity, std::string> names_;
  std::map<Entity, std::vector<std::int64_t>> groups_of_;
};

}  // namespace

FileMesh parse_msh(const std::filesystem::path& file, const std::string& bytes) {
  return MshFile(file, bytes).parse();
}

}  // namespace kinetostat::fea
