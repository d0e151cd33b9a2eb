// The region of the map that a query names.
#pragma once

#include "core/map/composed_map.h"
#include "core/records/map_reading.h"

namespace isthmus {

// Box, sphere and shape of RegionQuery, ExportRequest or ChangeQuery, whose map has that number.
template <typename Query>
Region RegionOf(const Query& query, uint32_t component) {
  Region region;
  if (query.box) region.box = *query.box;
  if (query.sphere) {
    region.has_sphere = true;
    region.center = query.sphere->center;
    region.radius_m = query.sphere->radius_m;
  }
  region.shape = MakeShape(query.shape);
  region.component = component;
  return region;
}

}  // namespace isthmus
