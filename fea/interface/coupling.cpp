#include "kinetostat/fea/interface/coupling.h"

namespace kinetostat::fea {

const char* name(Coupling coupling) {
  switch (coupling) {
    case Coupling::rigid:
      return "rigid";
    case Coupling::distributing:
      return "distributing";
    case Coupling::elastic:
      return "elastic";
    case Coupling::body:
      return "body";
  }
  return "";
}

}  // namespace kinetostat::fea
