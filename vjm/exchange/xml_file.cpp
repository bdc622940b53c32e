#include "kinetostat/vjm/exchange/xml_file.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <system_error>
#include <tinyxml2.h>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/common/error.h"
#include "kinetostat/common/spelling.h"
#include "kinetostat/io/largest_number.h"
#include "kinetostat/io/text_file.h"

namespace kinetostat::vjm {
namespace {

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

// Whether a text is finite numbers with blanks between.
bool read_numbers(const std::string& text, std::vector<double>& values) {
  const char* at = text.data();
  const char* const end = at + text.size();
  while (true) {
    while (at != end && is_blank(*at)) ++at;
    if (at == end) return true;
    if (*at == '+') ++at;
    double value = 0;
    const auto [after, error] = std::from_chars(at, end, value);
    if (error != std::errc() || !(std::abs(value) <= io::largest_number)) return false;
    if (after != end && !is_blank(*after)) return false;
    values.push_back(value);
    at = after;
  }
}

std::string reason_of(tinyxml2::XMLError error) {
  switch (error) {
    case tinyxml2::XML_ERROR_EMPTY_DOCUMENT:
      return "nothing is in it";
    case tinyxml2::XML_ERROR_MISMATCHED_ELEMENT:
      return "an element is not closed, or closed by another name";
    case tinyxml2::XML_ERROR_PARSING_ELEMENT:
      return "an element is not finished";
    case tinyxml2::XML_ERROR_PARSING_ATTRIBUTE:
      return "an attribute is not written as name=\"value\"";
    case tinyxml2::XML_ERROR_PARSING_COMMENT:
      return "a comment is not closed by '-->'";
    case tinyxml2::XML_ELEMENT_DEPTH_EXCEEDED:
      return "elements are nested too deeply";
    default:
      return "it is cut off, or has something between its elements that XML does not know";
  }
}

}  // namespace

XmlFile::Document XmlFile::read(std::filesystem::path file) {
  Document read{.file = std::move(file), .content = std::make_unique<tinyxml2::XMLDocument>()};
  const std::string text = io::read_text(read.file);
  if (read.content->Parse(text.data(), text.size()) != tinyxml2::XML_SUCCESS)
    throw common::InputError({.file = read.file,
                              .line = read.content->ErrorLineNum(),
                              .what = "this is not XML: " + reason_of(read.content->ErrorID())});
  return read;
}

XmlFile::XmlFile(std::filesystem::path file) { documents_.push_back(read(std::move(file))); }

XmlFile::~XmlFile() = default;

std::string XmlFile::root_name() const {
  const Element* root = documents_.front().content->RootElement();
  return root == nullptr ? "" : root->Name();
}

const XmlFile::Element& XmlFile::root(const char* name, const char* format) const {
  const Element* root = documents_.front().content->FirstChildElement(name);
  if (root == nullptr)
    throw common::InputError(file(), fmt::format("there is no <{}> element", name),
                             fmt::format("Give a {} file", format));
  return *root;
}

const XmlFile::Element& XmlFile::include(const Element& element, const char* attribute) {
  const std::filesystem::path other =
      (file().parent_path() / text(element, attribute)).lexically_normal();
  std::error_code unusable;  // as of a name that is too long
  if (!std::filesystem::is_regular_file(other, unusable))
    fail(element, fmt::format("there is no file '{}' to include", other.string()),
         "Put it there, or correct the name");
  for (const Document& known : documents_)
    if (std::filesystem::equivalent(known.file, other, unusable))
      fail(element, fmt::format("'{}' is included twice", other.string()));
  documents_.push_back(read(other));
  const Element* root = documents_.back().content->RootElement();
  if (root == nullptr) fail(element, fmt::format("nothing is in '{}'", other.string()));
  return *root;
}

const XmlFile::Document& XmlFile::document_of(const Element& element) const {
  return *std::find_if(documents_.begin(), documents_.end(), [&element](const Document& d) {
    return d.content.get() == element.GetDocument();
  });
}

int XmlFile::line(const Element& element) const {
  return &document_of(element) == &documents_.front() ? element.GetLineNum() : 0;
}

void XmlFile::fail(const Element& element, const std::string& what, const std::string& cure) const {
  throw common::InputError({.file = document_of(element).file,
                            .line = element.GetLineNum(),
                            .key = fmt::format("<{}>", element.Name()),
                            .what = what,
                            .cure = cure});
}

void XmlFile::fail_unknown(const Element& element, const std::string& what, const std::string& word,
                           const std::vector<std::string>& known) const {
  const std::string near = common::nearest_spelling(word, known);
  fail(element, fmt::format("{} '{}' is not known", what, word),
       near.empty() ? fmt::format("Known are {}", fmt::join(known, ", "))
                    : fmt::format("Did you mean '{}'?", near));
}

std::vector<const XmlFile::Element*> XmlFile::children(const Element& parent, const char* name) {
  std::vector<const Element*> result;
  for (const Element* e = parent.FirstChildElement(name); e != nullptr;
       e = e->NextSiblingElement(name))
    result.push_back(e);
  return result;
}

const XmlFile::Element* XmlFile::child(const Element& parent, const char* name) {
  return parent.FirstChildElement(name);
}

std::string XmlFile::text(const Element& element, const char* attribute) const {
  const char* value = element.Attribute(attribute);
  if (value == nullptr || *value == '\0')
    fail(element, fmt::format("the attribute '{}' is missing", attribute));
  return value;
}

std::string XmlFile::text_or(const Element& element, const char* attribute,
                             const std::string& otherwise) const {
  return has(element, attribute) ? text(element, attribute) : otherwise;
}

bool XmlFile::has(const Element& element, const char* attribute) const {
  return element.Attribute(attribute) != nullptr;
}

std::string XmlFile::choice_or(const Element& element, const char* attribute,
                               const std::vector<std::string>& words,
                               const std::string& otherwise) const {
  std::string word = text_or(element, attribute, otherwise);
  if (std::find(words.begin(), words.end(), word) == words.end())
    fail_unknown(element, fmt::format("the {}", attribute), word, words);
  return word;
}

std::string XmlFile::raw(const Element& element, const char* attribute) const {
  if (attribute != nullptr) return text(element, attribute);
  const char* inside = element.GetText();
  return inside == nullptr ? "" : inside;
}

std::vector<double> XmlFile::numbers(const Element& element, const char* attribute) const {
  std::vector<double> values;
  const std::string text = raw(element, attribute);
  if (!read_numbers(text, values))
    fail(element, fmt::format("\"{}\" is not finite numbers with blanks between", text));
  return values;
}

std::vector<double> XmlFile::numbers(const Element& element, const char* attribute,
                                     std::size_t count) const {
  std::vector<double> values;
  const std::string text = raw(element, attribute);
  if (!read_numbers(text, values) || values.size() != count)
    fail(element, fmt::format("{}\"{}\" is not {} finite number{}",
                              attribute == nullptr ? "" : fmt::format("{}=", attribute), text,
                              count, count == 1 ? "" : "s"));
  return values;
}

double XmlFile::number(const Element& element, const char* attribute) const {
  return numbers(element, attribute, 1)[0];
}

double XmlFile::number_or(const Element& element, const char* attribute, double otherwise) const {
  return has(element, attribute) ? number(element, attribute) : otherwise;
}

double XmlFile::not_negative(const Element& element, const char* attribute,
                             const char* what) const {
  const double value = number(element, attribute);
  if (value < 0) fail(element, fmt::format("{} cannot be negative", what));
  return value;
}

spatial::Vector3 XmlFile::vector(const Element& element, const char* attribute) const {
  const std::vector<double> v = numbers(element, attribute, 3);
  return {v[0], v[1], v[2]};
}

spatial::Vector3 XmlFile::vector_or(const Element* element, const char* attribute,
                                    const spatial::Vector3& otherwise) const {
  return element == nullptr || !has(*element, attribute) ? otherwise : vector(*element, attribute);
}

spatial::Vector3 XmlFile::direction(const Element& element, const char* attribute) const {
  const spatial::Vector3 given = vector(element, attribute);
  if (!(given.norm() > 1e-9)) fail(element, "the axis has no length");
  return given.normalized();
}

}  // namespace kinetostat::vjm
