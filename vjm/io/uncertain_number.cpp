#include "kinetostat/vjm/io/uncertain_number.h"

#include <cmath>

#include <fmt/format.h>

namespace kinetostat::vjm {
namespace {

double read_spread(const io::YamlNode& node, const spatial::Dimension& dimension,
                   const spatial::UnitSystem& units, double value) {
  const bool relative = node.text().find('%') != std::string::npos;
  const double spread = relative ? value * node.quantity(spatial::dimension::none, units)
                                 : node.quantity(dimension, units);
  if (!(spread >= 0)) node.fail("an uncertainty must not be negative");
  return spread;
}

// "E of steel".
UncertaintySource source_of(const io::YamlNode& node, SourceKind kind) {
  const std::string& path = node.path();
  const std::size_t first = path.find('.'), last = path.rfind('.');
  const std::string part = path.substr(first + 1, path.find('.', first + 1) - first - 1);
  return {.name = path.substr(last + 1) + " of " + part, .place = {}, .kind = kind};
}

}  // namespace

double PartNumbers::operator()(const io::YamlNode& node,
                               const spatial::Dimension& dimension) const {
  return read_uncertain(node, dimension, units, source_of(node, kind), sources);
}

bool is_uncertain(const io::YamlNode& node) {
  return node.is_map() && (node.has("value") || node.has("sd") || node.has("plus_minus"));
}

UncertaintySource stiffness_source(const io::YamlNode& node, const std::string& joint,
                                   const std::string& chain) {
  UncertaintySource source{.name = "stiffness of " + joint,
                           .place = node.file().string() + ": " + node.path(),
                           .kind = SourceKind::joint};
  if (const std::size_t of_table = node.path().rfind(".is["); of_table != std::string::npos)
    source.name += ", " + node.path().substr(of_table + 1);
  const auto each = node.is_map() ? node.find("each") : std::nullopt;
  if (each && each->boolean()) {
    source.name.replace(0, std::string("stiffness of ").size(), "stiffness of " + chain + ".");
    source.place += " of " + chain;
  }
  return source;
}

double read_uncertain(const io::YamlNode& node, const spatial::Dimension& dimension,
                      const spatial::UnitSystem& units, UncertaintySource like,
                      SourceList& sources) {
  if (!node.is_map()) return node.positive(dimension, units);
  std::vector<std::string> keys{"value", "sd", "plus_minus"};
  if (like.kind == SourceKind::joint) keys.emplace_back("each");
  node.allow_only(keys);
  like.value = like.estimate = node.at("value").positive(dimension, units);
  const auto [kind, given] = node.one_of({"sd", "plus_minus"});
  like.deviation = read_spread(given, dimension, units, like.value);
  like.spread = Spread::log_normal;
  if (kind == "plus_minus") {
    if (!(like.deviation < like.value))
      given.fail(fmt::format("the range reaches from {:.4g} below the value, {:.4g}, to zero",
                             like.deviation, like.value),
                 "Give the half width of a range of positive numbers");
    like.spread = Spread::rectangular;
    like.deviation /= std::sqrt(3.0);
  }
  if (like.deviation == 0) return like.value;
  if (like.place.empty()) like.place = node.file().string() + ": " + node.path();
  return sources.meet(like).value_or(like.value);
}

}  // namespace kinetostat::vjm
