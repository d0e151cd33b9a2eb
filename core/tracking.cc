#include "core/tracking.h"

namespace isthmus {

const char* ToString(Tracking tracking) {
  switch (tracking) {
    case Tracking::kUnknown:
      return "";
    case Tracking::kOk:
      return "ok";
    case Tracking::kDegenerate:
      return "degenerate";
    case Tracking::kLost:
      return "lost";
  }
  return "";
}

}  // namespace isthmus
