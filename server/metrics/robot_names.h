// The names under which robots are counted: their own, for so many, and one that the rest share.
#pragma once

#include <cstddef>
#include <set>
#include <string>

#include "core/concurrency/mutex.h"
#include "core/ids.h"

namespace isthmus::metrics {

// No robot's name has brackets.
inline constexpr char kOtherRobots[] = "(others)";

// The first robots keep their names as long as the server runs, so that a series is of one robot.
// Thread safe.
class RobotNames {
 public:
  explicit RobotNames(size_t most) : most_(most) {}

  // One that gave no name is among the others.
  std::string NameOf(const RobotId& robot);

 private:
  const size_t most_;
  Mutex mutex_;
  std::set<RobotId> named_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace isthmus::metrics
