// A computation for which there is not enough memory, said so that its user can do something.
#pragma once

#include <new>
#include <string>

namespace kinetostat::common {

/// what() says for what memory ran out, and what would take less. The program ends with exit code
/// 6, as it does for any std::bad_alloc.
class OutOfMemory : public std::bad_alloc {
 public:
  explicit OutOfMemory(std::string text) : text_(std::move(text)) {}
  const char* what() const noexcept override { return text_.c_str(); }

 private:
  std::string text_;
};

}  // namespace kinetostat::common
