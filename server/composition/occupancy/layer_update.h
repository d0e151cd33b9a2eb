// An update of kept evidence to the submaps of today: rays are cast again only where submaps came,
// moved or went.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <vector>

#include "core/map/composed_map.h"
#include "server/composition/occupancy/evidence_layer.h"
#include "server/composition/occupancy/occupancy_options.h"
#include "server/composition/occupancy/region_cut.h"

namespace isthmus::composition {

struct UpdatedLayer {
  EvidenceLayer layer;   // Has all columns in the region; of others those that are still right.
  uint64_t missing = 0;  // Submaps that the reader had not.
  uint64_t columns_cast = 0;
};

// `kept` may hold evidence of other submaps at other poses, of this resolution and range; null:
// none. Columns do not depend on it, nor on the region: each holds the evidence of all rays of
// `submaps`, in this order. No submap may be null. Reads a submap once or twice if `kept` does not
// know it, or if it reaches a column that has to be cast.
//
// OutOfRange, ResourceExhausted as WriteOccupancy; Cancelled by options.region.keep_on, which is
// asked before each submap is read.
absl::StatusOr<UpdatedLayer> UpdateLayer(const EvidenceLayer* kept,
                                         const std::vector<const PlacedSubmap*>& submaps,
                                         const SubmapReader& reader,
                                         const OccupancyOptions& options);

// ResourceExhausted, saying what to ask for instead.
absl::Status TooLargeOctomap(const OccupancyOptions& options);

// Equal for a submap of the same content at the same pose.
uint64_t IdentityOf(const PlacedSubmap& placed);

}  // namespace isthmus::composition
