#include "kinetostat/vjm/chain/coordinate.h"

namespace kinetostat::vjm {

std::string to_string(Motion motion) {
  static const char* names[] = {"Tx", "Ty", "Tz", "Rx", "Ry", "Rz"};
  return names[static_cast<int>(motion)];
}

}  // namespace kinetostat::vjm
