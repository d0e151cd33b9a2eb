// When a place counts as seen again.
#pragma once

namespace isthmus::matching {

struct LoopOptions {
  bool enabled = true;
};

}  // namespace isthmus::matching
