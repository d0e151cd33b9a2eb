// A forest of decision trees that tells classes by features (Breiman, "Random forests", Machine
// Learning 45, 2001), as lab/bench/classes/train.py makes it.
#pragma once

#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>

#include <array>
#include <cstdint>
#include <vector>

#include "core/map/point_class.h"
#include "server/classes/features.h"

namespace isthmus::classes {

// Probabilities of the classes, in order of their numbers; kUnknown's is 0.
using Shares = std::array<float, kPointClasses>;

// Immutable; thread safe.
class Forest {
 public:
  // As trained for these features; DataLoss for bytes that are no such forest.
  static absl::StatusOr<Forest> Read(absl::string_view bytes);
  // The one that is part of the program.
  static const Forest& Own();

  // The mean over the trees to the power at which probabilities were found true (temperature
  // scaling: Guo et al., "On calibration of modern neural networks", ICML 2017).
  Shares Tell(const Features& features) const;

 private:
  // An inner node goes on to `next` where the feature is at most the threshold, else to `next` + 1;
  // a leaf, which has feature kLeaf, has its shares at `next`.
  struct Node {
    float threshold = 0;
    uint16_t feature = 0;
    uint16_t next = 0;  // Within the tree.
  };
  struct Tree {
    std::vector<Node> nodes;
    std::vector<std::array<uint8_t, kPointClasses>> leaves;  // In 255ths.
  };
  static constexpr uint16_t kLeaf = 0xffff;

  std::vector<Tree> trees_;
  std::array<float, 256> sharpened_ = {};  // By shares in 255ths.
};

}  // namespace isthmus::classes
