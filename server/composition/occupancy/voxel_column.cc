#include "server/composition/occupancy/voxel_column.h"

#include <iterator>

namespace isthmus::composition {

static_assert(kBlocksAcross == kBlockEdge, "InLayer shifts by kBlockBits");

VoxelCell& VoxelColumn::Make(const VoxelIndex& index) {
  const int32_t z = index.z() >> kBlockBits;
  if (layers_.empty()) bottom_ = z;
  if (z < bottom_) {
    std::vector<std::unique_ptr<Layer>> below(static_cast<size_t>(bottom_ - z));
    layers_.insert(layers_.begin(), std::make_move_iterator(below.begin()),
                   std::make_move_iterator(below.end()));
    bottom_ = z;
  }
  if (z >= top()) layers_.resize(static_cast<size_t>(z - bottom_) + 1);
  std::unique_ptr<Layer>& layer = layers_[static_cast<size_t>(z - bottom_)];
  if (layer == nullptr) {
    layer = std::make_unique<Layer>();
    bytes_ += sizeof(Layer);
  }
  std::unique_ptr<VoxelBlock>& block = (*layer)[InLayer(index)];
  if (block == nullptr) {
    block = std::make_unique<VoxelBlock>();
    bytes_ += sizeof(VoxelBlock);
  }
  return (*block)[CellInBlock(index.x(), index.y(), index.z())];
}

}  // namespace isthmus::composition
