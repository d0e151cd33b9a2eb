#include "client/readers/static_frames.h"

#include <absl/strings/match.h>
#include <absl/strings/strip.h>

namespace isthmus::readers {
namespace {

std::string Plain(const std::string& name) { return std::string(absl::StripPrefix(name, "/")); }

bool IsCalled(const std::string& frame, const std::string& name) {
  return frame == name || absl::EndsWith(frame, "/" + name);
}

}  // namespace

StaticFrames::StaticFrames(const std::vector<StaticTransform>& edges) {
  for (const StaticTransform& edge : edges) {
    parents_[Plain(edge.child)] = {Plain(edge.parent), edge.T_parent_child};
  }
}

std::vector<StaticFrames::Ancestor> StaticFrames::Ancestors(const std::string& frame) const {
  std::vector<Ancestor> all = {{Plain(frame), Pose()}};
  // A recording may hold a cycle: there are no more frames above one than there are edges.
  while (all.size() <= parents_.size()) {
    const auto parent = parents_.find(all.back().name);
    if (parent == parents_.end()) break;
    all.push_back(
        {parent->second.name, parent->second.T_parent_child * all.back().T_ancestor_frame});
  }
  return all;
}

std::optional<Pose> StaticFrames::Between(const std::string& target,
                                          const std::string& source) const {
  if (target.empty() || source.empty()) return std::nullopt;
  const std::vector<Ancestor> of_target = Ancestors(target);
  for (const Ancestor& above_source : Ancestors(source)) {
    for (const Ancestor& above_target : of_target) {
      if (above_target.name != above_source.name) continue;
      return above_target.T_ancestor_frame.Inverse() * above_source.T_ancestor_frame;
    }
  }
  return std::nullopt;
}

std::string StaticFrames::BaseOf(const std::string& sensor) const {
  for (const char* name : {"base_link", "base_footprint"}) {
    for (const Ancestor& above : Ancestors(sensor)) {
      if (IsCalled(above.name, name)) return above.name;
    }
  }
  return "";
}

}  // namespace isthmus::readers
