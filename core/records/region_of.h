// The region of the map that a query names.
#pragma once

#include "core/map/composed_map.h"
#include "core/records/map_reading.h"

namespace isthmus {

// Box, sphere, shape and component of RegionQuery, ExportRequest or ChangeQuery.
template <typename Query>
Region RegionOf(const Query& query) {
  Region region;
  if (query.box) region.box = *query.box;
  if (query.sphere) {
    region.has_sphere = true;
    region.center = query.sphere->center;
    region.radius_m = query.sphere->radius_m;
  }
  region.shape = MakeShape(query.shape);
  region.component = query.component;
  return region;
}

}  // namespace isthmus
