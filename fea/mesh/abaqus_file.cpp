#include <algorithm>
#include <cctype>
#include <charconv>
#include <optional>
#include <string_view>
#include <unordered_map>

#include <fmt/format.h>

#include "kinetostat/common/error.h"
#include "kinetostat/common/index.h"
#include "kinetostat/fea/mesh/mesh_file.h"

namespace kinetostat::fea {
namespace {

using common::at;
using common::InputError;

std::string_view trimmed(std::string_view text) {
  const auto space = [](char c) { return std::isspace(static_cast<unsigned char>(c)) != 0; };
  while (!text.empty() && space(text.front())) text.remove_prefix(1);
  while (!text.empty() && space(text.back())) text.remove_suffix(1);
  return text;
}

std::string upper(std::string_view text) {
  std::string result(text);
  std::transform(result.begin(), result.end(), result.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return result;
}

std::vector<std::string_view> split(std::string_view line) {
  std::vector<std::string_view> parts;
  for (std::size_t begin = 0; begin <= line.size();) {
    const std::size_t end = std::min(line.find(',', begin), line.size());
    parts.push_back(trimmed(line.substr(begin, end - begin)));
    begin = end + 1;
  }
  return parts;
}

// "*ELEMENT, TYPE=C3D10, ELSET=arm": the word, and the parameters by name.
struct Keyword {
  std::string word;
  std::map<std::string, std::string> parameters;

  explicit Keyword(std::string_view line) {
    const std::vector<std::string_view> parts = split(line.substr(1));
    word = upper(parts.front());
    for (std::size_t i = 1; i < parts.size(); ++i) {
      const std::size_t equals = parts[i].find('=');
      const bool has_value = equals != std::string_view::npos;
      std::string_view value = has_value ? trimmed(parts[i].substr(equals + 1)) : "";
      if (value.size() >= 2 && value.front() == '"' && value.back() == '"')
        value = value.substr(1, value.size() - 2);
      parameters[upper(trimmed(parts[i].substr(0, equals)))] = std::string(value);
    }
  }
  bool has(const std::string& name) const { return parameters.contains(name); }
  std::string value(const std::string& name) const {
    const auto found = parameters.find(name);
    return found == parameters.end() ? "" : found->second;
  }
};

enum class Shape { tetrahedron, triangle, other_solid, none };

struct ElementType {
  Shape shape = Shape::none;
  int nodes = 0;
};

ElementType type_named(const std::string& name) {
  if (name.starts_with("C3D10")) return {Shape::tetrahedron, 10};
  if (name.starts_with("C3D4")) return {Shape::tetrahedron, 4};
  if (name.starts_with("C3D") || name.starts_with("SC6") || name.starts_with("SC8"))
    return {Shape::other_solid, 0};
  for (const char* const six : {"STRI65", "CPS6", "CPE6", "M3D6", "S6", "CAX6"})
    if (name.starts_with(six)) return {Shape::triangle, 6};
  for (const char* const three : {"STRI3", "CPS3", "CPE3", "M3D3", "S3", "SFM3D3", "R3D3", "CAX3"})
    if (name.starts_with(three)) return {Shape::triangle, 3};
  return {};
}

class InpFile {
 public:
  InpFile(const std::filesystem::path& file, const std::string& bytes)
      : file_(file), text_(bytes) {}

  FileMesh parse() && {
    // Nodes may stand below the elements that name them.
    for (const bool nodes : {true, false}) {
      at_ = 0;
      line_ = 0;
      while (next_line())
        if (is_keyword()) read_keyword(nodes);
    }
    for (const auto& [name, entries] : element_sets_) resolve_elements(name, entries);
    for (const auto& [name, entries] : node_sets_) resolve_nodes(entries, mesh_.groups[name].nodes);
    for (const auto& surface : surfaces_) resolve_surface(surface);
    return std::move(mesh_);
  }

 private:
  // What a set is made of: numbers, or names of other sets, with the line for messages.
  struct Entry {
    std::string text;
    int line;
  };
  using Entries = std::vector<Entry>;
  struct Side {
    Entry of;  // element or set of elements
    int side;
  };
  struct Surface {
    std::string name;
    std::vector<Side> sides;
    Entries nodes;
  };
  struct Element {
    bool is_tet;
    int index;
  };

  [[noreturn]] void fail(int line, const std::string& what, const std::string& cure) const {
    InputError::Details details;
    details.file = file_;
    details.line = line;
    details.what = what;
    details.cure = cure;
    throw InputError(details);
  }

  // The next line that is neither empty nor a comment.
  bool next_line() {
    while (at_ < text_.size()) {
      const std::size_t end = std::min(text_.find('\n', at_), text_.size());
      current_ = trimmed(std::string_view(text_).substr(at_, end - at_));
      at_ = end + 1;
      ++line_;
      if (!current_.empty() && !current_.starts_with("**")) return true;
    }
    return false;
  }
  // The next line when it holds data; a keyword line is left where it is.
  bool next_data() {
    const std::size_t at = at_;
    const int line = line_;
    if (!next_line()) return false;
    if (!is_keyword()) return true;
    at_ = at;
    line_ = line;
    return false;
  }
  bool is_keyword() const { return current_.starts_with("*"); }

  // Names differ by more than upper and lower case: the first spelling stands for all.
  std::string spelled(const std::string& name) {
    return name.empty() ? name : spelling_.try_emplace(upper(name), name).first->second;
  }

  template <class Number>
  Number number(std::string_view text, const char* what) const {
    Number value{};
    const std::string_view digits = text.starts_with("+") ? text.substr(1) : text;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (error != std::errc() || end != digits.data() + digits.size())
      fail(line_, fmt::format("'{}' is not {}", text.substr(0, 30), what),
           "Separate numbers by commas");
    return value;
  }

  void read_keyword(bool nodes) {
    const Keyword keyword(current_);
    if ((keyword.word == "NODE") != nodes) return;
    if (keyword.has("INPUT") &&
        (keyword.word == "INCLUDE" || keyword.word == "NODE" || keyword.word == "ELEMENT"))
      fail(line_,
           fmt::format("*{} refers to another file, {}", keyword.word, keyword.value("INPUT")),
           "Put its lines in the place of this one");
    if (keyword.word == "NODE")
      read_nodes(keyword);
    else if (keyword.word == "ELEMENT")
      read_elements(keyword);
    else if (keyword.word == "ELSET")
      read_set(keyword, "ELSET", element_sets_);
    else if (keyword.word == "NSET")
      read_set(keyword, "NSET", node_sets_);
    else if (keyword.word == "SURFACE")
      read_surface(keyword);
    else if (keyword.word == "INSTANCE")
      read_instance();
  }

  // Parts and instances are read as one flat model: right as long as nothing is moved or repeated.
  void read_instance() {
    if (++instances_ > 1)
      fail(line_, "the assembly has more than one *INSTANCE", "Write the link as one part");
    if (next_data())
      fail(line_, "the *INSTANCE is moved against its part", "Write the part in its place");
  }

  void read_nodes(const Keyword& keyword) {
    const std::string set = spelled(keyword.value("NSET"));
    while (next_data()) {
      const std::vector<std::string_view> parts = split(current_);
      if (parts.size() < 4)
        fail(line_, fmt::format("'{}' is not a node", current_.substr(0, 40)),
             "A node is: number, x, y, z");
      const int id = number<int>(parts[0], "the number of a node");
      Vector3 point;
      for (std::size_t k = 0; k < 3; ++k)
        point[static_cast<Eigen::Index>(k)] = number<double>(parts[k + 1], "a coordinate");
      if (!point.allFinite()) fail(line_, fmt::format("node {} is not finite", id), "Correct it");
      if (!node_index_.emplace(id, static_cast<int>(mesh_.points.size())).second)
        fail(line_, fmt::format("node {} is there twice", id), "Give every node its own number");
      mesh_.points.push_back(point);
      if (!set.empty()) node_sets_[set].push_back({std::string(parts[0]), line_});
    }
  }

  void read_elements(const Keyword& keyword) {
    const std::string name = upper(keyword.value("TYPE"));
    const ElementType type = type_named(name);
    if (type.shape == Shape::other_solid)
      fail(line_,
           fmt::format("elements of type {}; of solid elements only C3D4 and C3D10 are read", name),
           "Mesh the part with tetrahedra");
    if (name.empty()) fail(line_, "*ELEMENT without TYPE", "Name the type: *ELEMENT, TYPE=C3D10");
    const std::string set = spelled(keyword.value("ELSET"));
    while (next_data()) {
      const int line = line_;
      std::vector<int> numbers;
      take_numbers(numbers);
      if (type.shape == Shape::none) continue;  // lines, springs, masses
      const auto wanted = at(type.nodes) + 1;
      while (numbers.size() < wanted && next_data()) take_numbers(numbers);
      if (numbers.size() != wanted)
        fail(line,
             fmt::format("an element of type {} has a number and {} nodes; here are {} numbers",
                         name, type.nodes, numbers.size()),
             "Write the element with all its nodes");
      add_element(type, numbers, line);
      if (!set.empty()) element_sets_[set].push_back({std::to_string(numbers[0]), line});
    }
  }
  void take_numbers(std::vector<int>& numbers) const {
    for (const std::string_view part : split(current_))
      if (!part.empty()) numbers.push_back(number<int>(part, "a whole number"));
  }

  // The numbers are that of the element and those of its nodes.
  std::array<int, 10> nodes_of_element(const std::vector<int>& numbers, int line) const {
    std::array<int, 10> nodes{-1, -1, -1, -1, -1, -1, -1, -1, -1, -1};
    for (std::size_t k = 0; k + 1 < numbers.size(); ++k) {
      const auto found = node_index_.find(numbers[k + 1]);
      if (found == node_index_.end())
        fail(line,
             fmt::format("element {} names node {}, which the file does not have", numbers[0],
                         numbers[k + 1]),
             "Write the node under *NODE");
      nodes[k] = found->second;
    }
    return nodes;
  }

  void add_element(const ElementType& type, const std::vector<int>& numbers, int line) {
    const bool is_tet = type.shape == Shape::tetrahedron;
    const int index = static_cast<int>(is_tet ? mesh_.tets.size() : mesh_.triangles.size());
    if (!element_index_.emplace(numbers[0], Element{is_tet, index}).second)
      fail(line, fmt::format("element {} is there twice", numbers[0]),
           "Give every element its own number");
    const std::array<int, 10> nodes = nodes_of_element(numbers, line);
    if (is_tet)
      mesh_.tets.push_back(
          {.nodes = nodes, .node_count = type.nodes, .number = numbers[0], .line = line});
    else
      mesh_.triangles.push_back({nodes[0], nodes[1], nodes[2]});
  }

  void read_set(const Keyword& keyword, const std::string& parameter,
                std::map<std::string, Entries>& sets) {
    const std::string name = spelled(keyword.value(parameter));
    if (name.empty())
      fail(line_, fmt::format("*{} without a name", keyword.word),
           fmt::format("Write *{}, {}=NAME", keyword.word, parameter));
    Entries& entries = sets[name];
    while (next_data()) {
      const std::vector<std::string_view> parts = split(current_);
      if (keyword.has("GENERATE")) {
        add_range(parts, entries);
        continue;
      }
      for (const std::string_view part : parts)
        if (!part.empty()) entries.push_back({std::string(part), line_});
    }
  }
  void add_range(const std::vector<std::string_view>& parts, Entries& entries) const {
    if (parts.size() < 2)
      fail(line_, fmt::format("'{}' is not a range", current_.substr(0, 40)),
           "Write: first, last, step");
    const int first = number<int>(parts[0], "a whole number");
    const int last = number<int>(parts[1], "a whole number");
    const int step = parts.size() > 2 && !parts[2].empty() ? number<int>(parts[2], "a step") : 1;
    if (step < 1 || (last - first) / step > static_cast<int>(text_.size()))
      fail(line_, fmt::format("'{}' is not a range", current_.substr(0, 40)),
           "Write: first, last, step");
    for (int i = first; i <= last; i += step) entries.push_back({std::to_string(i), line_});
  }

  void read_surface(const Keyword& keyword) {
    Surface surface{.name = spelled(keyword.value("NAME")), .sides = {}, .nodes = {}};
    if (surface.name.empty()) fail(line_, "*SURFACE without a name", "Write *SURFACE, NAME=NAME");
    const bool of_nodes = upper(keyword.value("TYPE")) == "NODE";
    while (next_data()) {
      const std::vector<std::string_view> parts = split(current_);
      if (of_nodes)
        surface.nodes.push_back({std::string(parts[0]), line_});
      else
        surface.sides.push_back(
            {{std::string(parts[0]), line_}, parts.size() > 1 ? side_named(parts[1]) : -1});
    }
    surfaces_.push_back(std::move(surface));
  }
  int side_named(std::string_view text) const {
    const std::string name = upper(text);
    if (name == "SPOS" || name == "SNEG") return -1;  // the face of a shell
    if (name.size() == 2 && name[0] == 'S' && name[1] >= '1' && name[1] <= '4')
      return name[1] - '1';
    fail(line_, fmt::format("'{}' is not a side of a tetrahedron", text.substr(0, 20)),
         "The sides are S1, S2, S3 and S4");
  }

  // Calls visit(number, line) for all numbers of the entries, through sets within sets.
  static std::optional<int> number_in(const std::string& text) {
    const char first = text.empty() ? ' ' : text.front();
    if (!std::isdigit(static_cast<unsigned char>(first))) return {};
    int value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size()) return {};
    return value;
  }

  template <class Visit>
  void expand(const std::map<std::string, Entries>& sets, const Entries& entries, int depth,
              Visit visit) const {
    for (const Entry& entry : entries) {
      if (const std::optional<int> value = number_in(entry.text)) {
        visit(*value, entry.line);
        continue;
      }
      const auto spelling = spelling_.find(upper(entry.text));
      const auto found = spelling == spelling_.end() ? sets.end() : sets.find(spelling->second);
      if (found == sets.end() || depth > 20)
        fail(entry.line, fmt::format("'{}' is neither a number nor a set of this kind", entry.text),
             "Name a set that is in the file");
      expand(sets, found->second, depth + 1, visit);
    }
  }

  void resolve_elements(const std::string& name, const Entries& entries) {
    FileGroup& group = mesh_.groups[name];
    expand(element_sets_, entries, 0, [&](int number, int) {
      const auto found = element_index_.find(number);
      if (found == element_index_.end()) return;  // a kind of element that is passed over
      (found->second.is_tet ? group.tets : group.triangles).push_back(found->second.index);
    });
  }
  void resolve_nodes(const Entries& entries, std::vector<int>& nodes) const {
    expand(node_sets_, entries, 0, [&](int number, int line) {
      const auto found = node_index_.find(number);
      if (found == node_index_.end())
        fail(line, fmt::format("a set names node {}, which the file does not have", number),
             "Remove it from the set");
      nodes.push_back(found->second);
    });
  }
  const Element& element_of(const Surface& surface, int number, int line) const {
    const auto found = element_index_.find(number);
    if (found == element_index_.end())
      fail(line,
           fmt::format("the surface {} names element {}, which the file does not have",
                       surface.name, number),
           "Remove it from the surface");
    return found->second;
  }
  void resolve_surface(const Surface& surface) {
    FileGroup& group = mesh_.groups[surface.name];
    resolve_nodes(surface.nodes, group.nodes);
    for (const Side& side : surface.sides)
      expand(element_sets_, {side.of}, 0, [&](int number, int line) {
        const Element& element = element_of(surface, number, line);
        if (!element.is_tet)
          group.triangles.push_back(element.index);
        else if (side.side < 0)
          fail(line,
               fmt::format("the surface {} names solid element {} without a side", surface.name,
                           number),
               "Write: element, S1");
        else
          group.sides.emplace_back(element.index, side.side);
      });
  }

  const std::filesystem::path& file_;
  const std::string& text_;
  std::size_t at_ = 0;
  int line_ = 0, instances_ = 0;
  std::string_view current_;
  std::map<std::string, std::string> spelling_;  // of names, by their capitals

  FileMesh mesh_;
  std::unordered_map<int, int> node_index_;
  std::unordered_map<int, Element> element_index_;
  std::map<std::string, Entries> element_sets_, node_sets_;
  std::vector<Surface> surfaces_;
};

}  // namespace

FileMesh parse_inp(const std::filesystem::path& file, const std::string& bytes) {
  return InpFile(file, bytes).parse();
}

}  // namespace kinetostat::fea
