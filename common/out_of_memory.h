// A computation for which there is not enough memory, said so that its user can do something.
#pragma once

#include <new>
#include <string>

namespace kinetostat::common {

/// what() reads as that of InputError: "foot.yaml: 90000 nodes need more memory than there is. Use
/// a larger element size." The program ends with exit code 6, as it does for any std::bad_alloc.
class OutOfMemory : public std::bad_alloc {
 public:
  /// `reason`: for what memory ran out. `cure`: what would take less. `place`: the file that asks
  /// for it, or empty.
  OutOfMemory(const std::string& reason, const std::string& cure, const std::string& place = {})
      : reason_(reason), text_((place.empty() ? "" : place + ": ") + reason + ". " + cure + ".") {}
  const char* what() const noexcept override { return text_.c_str(); }
  const std::string& reason() const { return reason_; }

 private:
  std::string reason_, text_;
};

}  // namespace kinetostat::common
