// Walks once through XML that programs wrote, tag by tag, without building a tree of it.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace kinetostat::io {

/// The tags of well-formed XML in their order, with the text before each. Names come without their
/// namespace; comments, declarations and processing instructions are passed over. Damaged XML ends
/// early. Keeps a view of the text.
class XmlScanner {
 public:
  explicit XmlScanner(std::string_view xml) : xml_(xml) {}

  /// Moves to the next tag; false at the end.
  bool next();

  std::string_view name() const { return name_; }
  bool opens() const { return opens_; }    // <a> and <a/>
  bool closes() const { return closes_; }  // </a> and <a/>
  /// Text between the tag before and this one, entities replaced.
  std::string text() const;
  /// Of this tag, entities replaced; nullopt when it has none of this name (without namespace).
  std::optional<std::string> attribute(std::string_view name) const;

 private:
  std::string_view xml_, name_, attributes_, text_;
  std::size_t at_ = 0;
  bool opens_ = false, closes_ = false;
};

}  // namespace kinetostat::io
