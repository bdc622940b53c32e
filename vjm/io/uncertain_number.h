// Numbers above zero that a file may state with their uncertainty.
#pragma once

#include "kinetostat/io/yaml.h"
#include "kinetostat/vjm/io/uncertainty_source.h"

namespace kinetostat::vjm {

/// Reads `x`, `{value: x, sd: s}` or `{value: x, plus_minus: h}`, in SI: x with its standard
/// uncertainty, or with the half width of a range in which nothing is known of it (GUM 4.3.7: s is
/// h over the root of 3). The uncertainty is a quantity of the same dimension, or in %. `like` has
/// the name and the kind of the source, and its place where that is not the key; it goes into
/// `sources`, which may have another value. Throws common::InputError for what is negative, and for
/// a half width that reaches zero.
double read_uncertain(const io::YamlNode& node, const spatial::Dimension& dimension,
                      const spatial::UnitSystem& units, UncertaintySource like,
                      SourceList& sources);

/// The source that the stiffness of a joint is. With `each: true` the joint of every chain of a
/// type has a value of its own, else all have the same.
UncertaintySource stiffness_source(const io::YamlNode& node, const std::string& joint,
                                   const std::string& chain);

/// Reads numbers of a part that stands under `links` or `materials`, as read_uncertain() does: each
/// is one of that part, "E of steel".
struct PartNumbers {
  const spatial::UnitSystem& units;
  SourceList& sources;
  SourceKind kind;

  double operator()(const io::YamlNode& node, const spatial::Dimension& dimension) const;
};

/// Whether a map states a number with its uncertainty, and is not of another kind.
bool is_uncertain(const io::YamlNode& node);

}  // namespace kinetostat::vjm
