#include "core/match.h"

namespace isthmus {

const char* ToString(MatchState state) {
  switch (state) {
    case MatchState::kAccepted:
      return "ACCEPTED";
    case MatchState::kRejected:
      return "REJECTED";
    case MatchState::kAmbiguous:
      return "AMBIGUOUS";
    case MatchState::kNotYet:
      return "NOT_YET";
  }
  return "UNKNOWN";
}

}  // namespace isthmus
