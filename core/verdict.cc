#include "core/verdict.h"

namespace isthmus {

const char* ToString(Ruling ruling) {
  switch (ruling) {
    case Ruling::kAccept:
      return "ACCEPT";
    case Ruling::kReject:
      return "REJECT";
    case Ruling::kSet:
      return "SET";
  }
  return "UNKNOWN";
}

}  // namespace isthmus
