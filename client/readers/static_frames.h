// The mounting of sensors, by the static transforms of a recording.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "client/readers/recording.h"
#include "core/pose.h"

namespace isthmus::readers {

// Frames that static transforms join. Names are compared without a leading "/". Thread safe.
class StaticFrames {
 public:
  explicit StaticFrames(const std::vector<StaticTransform>& edges);

  // T_target_source; empty where the transforms do not join the two, or a name is empty.
  std::optional<Pose> Between(const std::string& target, const std::string& source) const;

  // The robot's own frame (REP 105): the nearest above `sensor` that is called base_link, else
  // base_footprint, whatever comes before the last "/". Empty where there is none.
  std::string BaseOf(const std::string& sensor) const;

 private:
  struct Parent {
    std::string name;
    Pose T_parent_child;
  };
  struct Ancestor {
    std::string name;
    Pose T_ancestor_frame;
  };
  // From the frame itself to the root.
  std::vector<Ancestor> Ancestors(const std::string& frame) const;

  std::map<std::string, Parent> parents_;  // By child.
};

}  // namespace isthmus::readers
