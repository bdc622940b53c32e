// Errors of a run, worded so that its user can correct them.
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>

namespace kinetostat::common {

/// A mistake in a user's input. The program ends with exit code 3 and prints what():
/// "robot.yaml:12: links.leg.beam.length: '-3 mm' is not positive. Give a length above zero."
class InputError : public std::runtime_error {
 public:
  struct Details {
    std::filesystem::path file = {};
    int line = 0;           // counted from 1; 0 when the whole file is meant
    int column = 0;         // counted from 1; 0 when the whole line is meant
    std::string key = {};   // "links.leg.beam.length", or a column name of a table; may be empty
    std::string what = {};  // what is wrong, with the offending value
    std::string cure = {};  // what would work; may be empty
  };

  explicit InputError(Details details);
  InputError(const std::filesystem::path& file, const std::string& what,
             const std::string& cure = {});

  const Details& details() const { return details_; }

 private:
  Details details_;
};

/// A computation on sound input that did not reach its tolerance. what() says how far it came and
/// what to change. The program ends with exit code 4.
class NoConvergence : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The data do not determine what was asked. what() says what is missing. Exit code 5.
class NotIdentifiable : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace kinetostat::common
