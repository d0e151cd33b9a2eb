#include "core/geometry/voxel_hash.h"

#include <sys/random.h>

namespace isthmus {
namespace {

struct Drawn {
  // Used if the system has no random numbers to give.
  uint64_t mask = 0, multiplier = 0x9e3779b97f4a7c15u;

  Drawn() {
    uint64_t random[2];
    if (getrandom(random, sizeof(random), GRND_NONBLOCK) != sizeof(random)) return;
    mask = random[0];
    multiplier = random[1] | 1;
  }
};

}  // namespace

VoxelHash::VoxelHash() {
  static const Drawn drawn;
  mask_ = drawn.mask;
  multiplier_ = drawn.multiplier;
}

}  // namespace isthmus
