#include "client/readers/recording.h"

namespace isthmus::readers {

absl::StatusOr<std::vector<GnssFix>> Recording::ReadFixes(size_t) const {
  return std::vector<GnssFix>();
}

absl::StatusOr<std::vector<StaticTransform>> Recording::ReadStaticTransforms() const {
  return std::vector<StaticTransform>();
}

}  // namespace isthmus::readers
