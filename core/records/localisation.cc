#include "core/records/localisation.h"

namespace isthmus {

const char* ToString(LocalisationState state) {
  switch (state) {
    case LocalisationState::kSearching:
      return "searching";
    case LocalisationState::kAmbiguous:
      return "ambiguous";
    case LocalisationState::kLocated:
      return "located";
    case LocalisationState::kUncertain:
      return "uncertain";
  }
  return "";
}

}  // namespace isthmus
