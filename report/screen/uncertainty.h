// How uncertain a number is, and by what, in words.
#pragma once

#include <string>

#include "kinetostat/vjm/uncertainty/draws.h"

namespace kinetostat::report {

/// " +- 9 %": the expanded uncertainty of a number beside its estimate. Empty for one that is
/// certain.
std::string spread_in_words(const vjm::Uncertainty& uncertainty, Eigen::Index number);
/// " Of its uncertainty, 62 % is stiffness of q3 and 30 % E of steel." Empty for one that is
/// certain.
std::string blame_sentence(const vjm::Uncertainty& uncertainty, Eigen::Index number);
/// "Known to +- 5 % to 12 %. Of its uncertainty on average, 62 % is stiffness of q3.": of several
/// numbers from `first` on. Empty where all are certain.
std::string range_sentence(const vjm::Uncertainty& uncertainty, Eigen::Index first,
                           Eigen::Index count);
/// Whether the estimate is another value than the file's, by a tenth of the expanded uncertainty or
/// more: links are clamped in it as their bracket has it on one side.
bool is_off_estimate(const vjm::Uncertainty& uncertainty, Eigen::Index number);

/// How a number is shown: `one_over` as its inverse, then times `factor`, in `unit`.
struct ShownNumber {
  std::string what;  // "stiffness along x"
  double factor = 1;
  std::string unit;
  bool one_over = false;
};
/// Rows of a screen: the interval to first order, that of draws, and a bar for each source.
std::string budget_text(const vjm::Uncertainty& uncertainty, Eigen::Index number,
                        const ShownNumber& shown);

}  // namespace kinetostat::report
