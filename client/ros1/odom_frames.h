// Names of the odom frames that a robot's poses are in, one after the other.
#pragma once

#include <map>
#include <string>

#include "core/ids.h"

namespace isthmus::ros1 {

// The first is called as it is told, the next ones odom_2, odom_3 and so on: poses of a new segment
// or session share nothing with those before, and under one name a robot would seem to have jumped.
// Not thread safe.
class OdomFrames {
 public:
  explicit OdomFrames(std::string first) : first_(std::move(first)) {}

  const std::string& NameOf(const SessionId& segment) {
    const auto [known, is_new] = names_.try_emplace(segment, first_);
    if (is_new && names_.size() > 1) known->second += "_" + std::to_string(names_.size());
    return known->second;
  }

 private:
  const std::string first_;
  std::map<SessionId, std::string> names_;
};

}  // namespace isthmus::ros1
