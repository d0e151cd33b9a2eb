#include "core/records/map_reading.h"

namespace isthmus {

std::shared_ptr<const Shape> MakeShape(const RegionShape& shape) {
  if (const auto* box = std::get_if<OrientedBox>(&shape)) {
    return std::make_shared<OrientedBoxShape>(box->T_map_box, box->size);
  }
  if (const auto* polygon = std::get_if<Polygon>(&shape)) {
    return std::make_shared<PolygonShape>(polygon->corners, polygon->heights);
  }
  if (const auto* corridor = std::get_if<Corridor>(&shape)) {
    return std::make_shared<CorridorShape>(corridor->path, corridor->width_m, corridor->heights);
  }
  return nullptr;
}

}  // namespace isthmus
