#include "server/composition/occupancy/evidence_layer.h"

namespace isthmus::composition {

uint64_t EvidenceLayer::bytes() const {
  uint64_t bytes = sizeof(*this);
  for (const auto& [id, cast] : submaps) {
    bytes += id.session.value().size() + sizeof(id) + sizeof(cast) +
             cast.columns->capacity() * sizeof(ColumnKey);
  }
  for (const auto& [key, column] : columns) {
    bytes += sizeof(key) + sizeof(column) + column.packed->bytes();
  }
  return bytes;
}

}  // namespace isthmus::composition
