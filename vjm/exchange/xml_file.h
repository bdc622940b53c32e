// XML files of robots: elements and attributes with their places for messages.
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "kinetostat/spatial/linear_algebra.h"

namespace tinyxml2 {
class XMLDocument;
class XMLElement;
}  // namespace tinyxml2

namespace kinetostat::vjm {

/// All accessors throw common::InputError with file and line.
class XmlFile {
 public:
  using Element = tinyxml2::XMLElement;

  /// Throws when the file is missing or not XML.
  explicit XmlFile(std::filesystem::path file);
  ~XmlFile();
  XmlFile(const XmlFile&) = delete;
  XmlFile& operator=(const XmlFile&) = delete;

  const std::filesystem::path& file() const { return documents_.front().file; }
  /// Of the outermost element; empty where there is none.
  std::string root_name() const;
  /// The outermost element of this name.
  const Element& root(const char* name, const char* format) const;
  /// The outermost element of another file, which an attribute names from the folder of this one.
  /// Elements of it have their places in messages, too. Throws when it has been included before.
  const Element& include(const Element& element, const char* attribute);
  /// Of an element; 0 where it is from an included file.
  int line(const Element& element) const;

  [[noreturn]] void fail(const Element& element, const std::string& what,
                         const std::string& cure = {}) const;
  /// Of a word that is none of those that are known: says `what` it is ("the joint type"), and the
  /// nearest of them or all.
  [[noreturn]] void fail_unknown(const Element& element, const std::string& what,
                                 const std::string& word,
                                 const std::vector<std::string>& known) const;

  /// Children of a name, in the order of the file.
  static std::vector<const Element*> children(const Element& parent, const char* name);
  /// nullptr where there is none.
  static const Element* child(const Element& parent, const char* name);

  /// An attribute that must be there and not empty.
  std::string text(const Element& element, const char* attribute) const;
  std::string text_or(const Element& element, const char* attribute,
                      const std::string& otherwise) const;
  bool has(const Element& element, const char* attribute) const;
  /// One of some words.
  std::string choice_or(const Element& element, const char* attribute,
                        const std::vector<std::string>& words, const std::string& otherwise) const;

  /// Finite numbers, with blanks between. `attribute` nullptr: in the text of the element.
  std::vector<double> numbers(const Element& element, const char* attribute) const;
  /// Exactly so many.
  std::vector<double> numbers(const Element& element, const char* attribute,
                              std::size_t count) const;
  double number(const Element& element, const char* attribute) const;
  double number_or(const Element& element, const char* attribute, double otherwise) const;
  /// Fails below 0, by the name of `what` it is ("a mass").
  double not_negative(const Element& element, const char* attribute, const char* what) const;
  spatial::Vector3 vector(const Element& element, const char* attribute) const;
  spatial::Vector3 vector_or(const Element* element, const char* attribute,
                             const spatial::Vector3& otherwise) const;
  /// A unit vector.
  spatial::Vector3 direction(const Element& element, const char* attribute) const;

 private:
  struct Document {
    std::filesystem::path file;
    std::unique_ptr<tinyxml2::XMLDocument> content;
  };
  static Document read(std::filesystem::path file);
  const Document& document_of(const Element& element) const;
  std::string raw(const Element& element, const char* attribute) const;

  std::vector<Document> documents_;  // the file itself, then those that it includes
};

}  // namespace kinetostat::vjm
