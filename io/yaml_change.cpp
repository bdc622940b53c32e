#include "kinetostat/io/yaml_change.h"

#include <algorithm>
#include <charconv>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <yaml-cpp/yaml.h>

#include "kinetostat/common/error.h"
#include "kinetostat/common/spelling.h"

namespace kinetostat::io::yaml_change {
namespace {

std::vector<std::string> parts_of(const std::string& key) {
  std::vector<std::string> parts(1);
  for (const char c : key) {
    if (c == '.')
      parts.emplace_back();
    else
      parts.back() += c;
  }
  return parts;
}

// What a list's item goes by: its name, or that of the one map within it.
std::string name_of(const YAML::Node& item) {
  if (!item.IsMap()) return {};
  if (const YAML::Node name = item["name"]; name && name.IsScalar()) return name.Scalar();
  if (item.size() != 1) return {};
  const YAML::Node inner = item.begin()->second;
  if (!inner.IsMap()) return inner.IsScalar() ? inner.Scalar() : "";
  const YAML::Node name = inner["name"];
  return name && name.IsScalar() ? name.Scalar() : "";
}

class Change {
 public:
  Change(const std::string& text, const std::filesystem::path& file, const std::string& key,
         const std::string& value)
      : text_(text), file_(file), key_(key), value_(value), parts_(parts_of(key)) {}

  std::string run() const {
    check_value();
    YAML::Node node = loaded(text_);
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      const YAML::Node next = child(node, parts_[i]);
      if (!next && i + 1 == parts_.size() && node.IsMap()) return checked(with_new_key(node));
      if (!next) refuse_part(node, i);
      node.reset(next);
    }
    const auto [begin, end] = extent(node);
    return checked(text_.substr(0, begin) + value_ + text_.substr(end));
  }

 private:
  [[noreturn]] void fail(const std::string& what, const std::string& cure = {}) const {
    throw common::InputError({.file = file_, .key = key_, .what = what, .cure = cure});
  }

  YAML::Node loaded(const std::string& text) const try {
    return YAML::Load(text);
  } catch (const YAML::Exception& error) {
    throw common::InputError({.file = file_,
                              .line = error.mark.line + 1,
                              .what = fmt::format("this is not YAML: {}", error.msg)});
  }

  void check_value() const {
    if (value_.find('\n') != std::string::npos || value_.empty())
      fail("the value must be one line of YAML", "Write --set links.leg.beam.length='300 mm'");
    try {
      (void)YAML::Load(value_);
    } catch (const YAML::Exception& error) {
      fail(fmt::format("'{}' is not YAML: {}", value_, error.msg));
    }
  }

  // Not there: a node that is false.
  static YAML::Node child(const YAML::Node& node, const std::string& part) {
    if (node.IsMap()) return std::as_const(node)[part];
    if (!node.IsSequence()) return YAML::Node(YAML::NodeType::Undefined);
    std::size_t number = 0;
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), number);
    if (error == std::errc() && end == part.data() + part.size())
      return number < node.size() ? std::as_const(node)[number]
                                  : YAML::Node(YAML::NodeType::Undefined);
    for (const YAML::Node& item : node) {
      if (name_of(item) != part) continue;
      // {actuator: {name: q1}} stands for what is within.
      const bool has_name_itself = item["name"].IsDefined();
      return has_name_itself || item.size() != 1 ? item : item.begin()->second;
    }
    return YAML::Node(YAML::NodeType::Undefined);
  }

  [[noreturn]] void refuse_part(const YAML::Node& node, std::size_t i) const {
    std::vector<std::string> known;
    if (node.IsMap())
      for (const auto& member : node)
        if (member.first.IsScalar()) known.push_back(member.first.Scalar());
    if (node.IsSequence())
      for (const YAML::Node& item : node)
        if (const std::string name = name_of(item); !name.empty()) known.push_back(name);
    const std::string near = common::nearest_spelling(parts_[i], known);
    const std::string where =
        i == 0
            ? std::string()
            : fmt::format(" under '{}'", fmt::join(parts_.begin(), parts_.begin() + long(i), "."));
    fail(fmt::format("there is no '{}'{}", parts_[i], where),
         !near.empty()   ? fmt::format("Did you mean '{}'?", near)
         : known.empty() ? std::string()
                         : fmt::format("Known here: {}", fmt::join(known, ", ")));
  }

  std::size_t start(const YAML::Node& node) const {
    const std::size_t mark = text_.starts_with("\xef\xbb\xbf") ? 3 : 0;
    return mark + static_cast<std::size_t>(std::max(node.Mark().pos, 0));
  }

  // First byte of a value, and the one behind it.
  std::pair<std::size_t, std::size_t> extent(const YAML::Node& node) const {
    const std::size_t begin = start(node);
    if (begin < text_.size()) {
      const char first = text_[begin];
      if (first == '{' || first == '[') return {begin, behind_bracket(begin)};
      if (first == '"' || first == '\'') return {begin, behind_quote(begin)};
      if (node.IsScalar() && text_.compare(begin, node.Scalar().size(), node.Scalar()) == 0)
        return {begin, begin + node.Scalar().size()};
    }
    fail("the value has several lines", "Set what is within it, key by key, or edit the file");
  }

  std::size_t behind_quote(std::size_t begin) const {
    const char quote = text_[begin];
    for (std::size_t at = begin + 1; at < text_.size(); ++at) {
      if (quote == '"' && text_[at] == '\\') {
        ++at;
      } else if (text_[at] == quote) {
        if (quote == '"' || at + 1 == text_.size() || text_[at + 1] != quote) return at + 1;
        ++at;  // a doubled single quote
      }
    }
    return text_.size();
  }

  std::size_t behind_bracket(std::size_t begin) const {
    int depth = 0;
    for (std::size_t at = begin; at < text_.size(); ++at) {
      const char c = text_[at];
      const bool starts_word =
          at == 0 || std::string_view(" \n\t,:[{").find(text_[at - 1]) != std::string_view::npos;
      if ((c == '"' || c == '\'') && starts_word) {
        at = behind_quote(at) - 1;
      } else if (c == '#' && starts_word) {
        at = std::min(text_.find('\n', at), text_.size());
      } else if (c == '{' || c == '[') {
        ++depth;
      } else if ((c == '}' || c == ']') && --depth == 0) {
        return at + 1;
      }
    }
    return text_.size();
  }

  std::string with_new_key(const YAML::Node& map) const {
    const std::size_t begin = start(map);
    const std::string entry = fmt::format("{}: {}", parts_.back(), value_);
    if (begin < text_.size() && text_[begin] == '{')
      return text_.substr(0, begin + 1) + entry + (map.size() == 0 ? "" : ", ") +
             text_.substr(begin + 1);
    return text_.substr(0, begin) + entry + "\n" +
           std::string(static_cast<std::size_t>(std::max(map.Mark().column, 0)), ' ') +
           text_.substr(begin);
  }

  // Whether the value is what stands there now, and nothing else has changed.
  std::string checked(const std::string& changed) const {
    YAML::Node node;
    try {
      node = YAML::Load(changed);
      for (const std::string& part : parts_) node.reset(child(node, part));
    } catch (const YAML::Exception&) {
      node = YAML::Node(YAML::NodeType::Undefined);
    }
    if (!node || YAML::Dump(node) != YAML::Dump(YAML::Load(value_)))
      fail(fmt::format("'{}' cannot stand there", value_),
           "Put it in quotes where it holds commas, colons or brackets");
    return changed;
  }

  const std::string& text_;
  const std::filesystem::path& file_;
  const std::string &key_, &value_;
  std::vector<std::string> parts_;
};

}  // namespace
}  // namespace kinetostat::io::yaml_change

namespace kinetostat::io {

std::string with_value(const std::string& text, const std::filesystem::path& file,
                       const std::string& key, const std::string& value) {
  return yaml_change::Change(text, file, key, value).run();
}

bool has_first_key(const std::string& text, const std::string& key) try {
  const YAML::Node top = YAML::Load(text);
  return top.IsMap() && top[key.substr(0, key.find('.'))].IsDefined();
} catch (const YAML::Exception&) {
  return false;
}

}  // namespace kinetostat::io
