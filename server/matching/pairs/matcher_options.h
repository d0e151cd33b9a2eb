// Conditions of accepting a pair of maps. A wrong merge destroys a map, a missed one costs a
// minute: when in doubt, raise the probability.
#pragma once

#include <cstdint>
#include <stop_token>
#include <string>

namespace isthmus::matching {

// The searches that propose transforms.
enum class SearchMode {
  // Searches from above and places that look alike, and the paper's feature chain where these find
  // nothing likely indoors (outdoors it costs seconds and finds nothing at realistic overlap).
  kDefault,
  kPaper,     // The feature chain only, where it was built (core/paper.h).
  kBirdsEye,  // The search only.
};

// The frequency of places built alike as wholes: halls, storeys, rooms with all that stands in
// them. No number computed from two maps of one closed place says whether there is another.
enum class Twins {
  kRare,      // Seldom, as in most: what is furnished as if it were one place is taken for one.
  kPossible,  // Closed places of up to 400 m2 wait, and larger ones the less the larger they are.
  kExact,     // Hotels, racks, test halls: a closed place waits, however large.
};

struct MatcherOptions {
  SearchMode search = SearchMode::kDefault;
  // Probability of being right (pairs/probability.h); less: AMBIGUOUS where another place is what
  // is in the way, else NOT_YET, or REJECTED.
  double min_probability = 0.95;
  // If neither map shows much beyond the ground that both know, a twin of the place explains both
  // equally well: unless such are rare the pair is AMBIGUOUS, until a robot sees more or anchors
  // tell.
  Twins twins = Twins::kRare;
  // Mean squared normal along the direction held least; less: NOT_YET, it slides. Streets and
  // fields are held by few surfaces, and rightly.
  double min_observability = 0.003;
  double max_odometry_residual =
      3;  // Standard deviations that the odometry may bend; more: NOT_YET.
  // If nothing is known of a pair, its search ends after a first look that finds no place at which
  // the maps might meet: a tenth of the time.
  bool first_look = false;
  // Ends a match early; what comes of it then is to be thrown away.
  std::stop_token stop = {};
};

}  // namespace isthmus::matching
