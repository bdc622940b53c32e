// Values of options: lists of numbers with units.
#pragma once

#include <string>
#include <vector>

#include "kinetostat/io/table_parts.h"
#include "kinetostat/spatial/linear_algebra.h"
#include "kinetostat/spatial/units.h"

namespace kinetostat::apps {

/// Parts between separators; a text without one is one part.
std::vector<std::string> split(const std::string& text, char separator = ',');

/// "2/8", the second of eight parts; the whole where the text is empty. Throws UsageError.
io::Part part_of(const std::string& option, const std::string& text);

/// A quantity in SI; a bare number is taken in the units of the file. Throws UsageError.
double quantity(const std::string& option, const std::string& text,
                const spatial::Dimension& dimension, const spatial::UnitSystem& units);

/// "a,b,c" or "a,b,c,d,e,f": three values, then three of another dimension that may be left out.
/// Throws UsageError.
spatial::Vector6 six_values(const std::string& option, const std::string& text,
                            const spatial::Dimension& first, const spatial::Dimension& second,
                            const spatial::UnitSystem& units);

/// "a,b,c". Throws UsageError.
spatial::Vector3 three_values(const std::string& option, const std::string& text,
                              const spatial::Dimension& dimension,
                              const spatial::UnitSystem& units);

}  // namespace kinetostat::apps
