#include "server/metrics/robot_names.h"

namespace isthmus::metrics {

std::string RobotNames::NameOf(const RobotId& robot) {
  if (robot.empty()) return kOtherRobots;
  MutexLock lock(&mutex_);
  if (named_.contains(robot)) return robot.value();
  if (named_.size() >= most_) return kOtherRobots;
  named_.insert(robot);
  return robot.value();
}

}  // namespace isthmus::metrics
