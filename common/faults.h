// Mistakes of one file, collected while it is read, so that all of them are reported at once.
#pragma once

#include <string>
#include <vector>

#include "kinetostat/common/error.h"

namespace kinetostat::common {

/// Several mistakes of one file. what() is a table with one line a mistake: place, what is wrong,
/// what would work; of those that one screen does not hold it ends in "and 12 more".
class InputErrors : public InputError {
 public:
  explicit InputErrors(std::vector<Details> mistakes);

  const char* what() const noexcept override { return text_.c_str(); }
  /// The table with all of them.
  std::string all() const;
  /// Whether what() leaves some out.
  bool is_cut() const { return text_.size() < all().size(); }
  const std::vector<Details>& mistakes() const { return mistakes_; }

 private:
  std::vector<Details> mistakes_;
  std::string text_;
};

class Faults {
 public:
  void add(InputError::Details mistake) { mistakes_.push_back(std::move(mistake)); }
  /// One mistake, or all that it holds.
  void add(const InputError& error);

  bool empty() const { return mistakes_.empty(); }
  /// Sorted by line, then column; what was found twice is there once.
  std::vector<InputError::Details> mistakes() const;
  /// One mistake is thrown as InputError, several as InputErrors.
  void throw_if_any() const;

 private:
  std::vector<InputError::Details> mistakes_;
};

}  // namespace kinetostat::common
