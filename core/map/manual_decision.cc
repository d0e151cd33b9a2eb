#include "core/map/manual_decision.h"

namespace isthmus {

const char* ToString(ManualDecisionKind kind) {
  switch (kind) {
    case ManualDecisionKind::kAccept:
      return "ACCEPT";
    case ManualDecisionKind::kReject:
      return "REJECT";
    case ManualDecisionKind::kSet:
      return "SET";
  }
  return "UNKNOWN";
}

}  // namespace isthmus
