#include "server/ingest/uploaded_submap.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "core/map/rounded.h"
#include "server/ingest/limits.h"

namespace isthmus::ingest {
absl::StatusOr<FinishedSubmap> MakeUploadedSubmap(Submap submap) {
  // Trajectory entries of a submap are numbered from index * this + 1.
  constexpr uint64_t kKeyframesPerSubmap = 65536;
  const std::string name = ToString(submap.id);
  if (submap.points.empty()) {
    return absl::InvalidArgumentError(absl::StrCat("submap ", name, " has no points"));
  }
  if (submap.keyframes.empty() || submap.keyframes.size() >= kKeyframesPerSubmap) {
    return absl::InvalidArgumentError(
        absl::StrCat("submap ", name, " has ", submap.keyframes.size(),
                     " keyframes: give 1 to 65535, the poses its sensor stood at"));
  }
  bool finite = submap.T_odom_submap.IsFinite();
  for (const Keyframe& keyframe : submap.keyframes) finite &= keyframe.T_submap_sensor.IsFinite();
  for (const SubmapPoint& point : submap.points) {
    finite &= point.Position().allFinite();
    if (point.keyframe >= submap.keyframes.size()) {
      return absl::InvalidArgumentError(absl::StrCat("submap ", name, ": a point names keyframe ",
                                                     point.keyframe, " of ",
                                                     submap.keyframes.size()));
    }
  }
  if (!finite) {
    return absl::InvalidArgumentError(
        absl::StrCat("submap ", name, " has coordinates that are not finite: remove them"));
  }
  for (SubmapPoint& point : submap.points) {
    for (float* v : {&point.x, &point.y, &point.z}) *v = Rounded(*v, kStoredStepM);
  }
  std::stable_sort(
      submap.points.begin(), submap.points.end(),
      [](const SubmapPoint& a, const SubmapPoint& b) { return a.keyframe < b.keyframe; });
  const uint64_t first = submap.id.index * kKeyframesPerSubmap + 1;
  submap.first_sequence = first;
  submap.last_sequence = first + submap.keyframes.size() - 1;
  FinishedSubmap finished;
  for (size_t i = 0; i < submap.keyframes.size(); ++i) {
    Keyframe& keyframe = submap.keyframes[i];
    keyframe.sequence = 0;
    finished.trajectory.push_back({first + i, keyframe.stamp_ns,
                                   submap.T_odom_submap * keyframe.T_submap_sensor,
                                   submap.id.index});
  }
  finished.submap = std::make_shared<const Submap>(std::move(submap));
  return finished;
}

bool SameSubmap(const Submap& stored, const Submap& repeated) {
  if (stored.points.size() != repeated.points.size() ||
      stored.keyframes.size() != repeated.keyframes.size() ||
      !stored.T_odom_submap.Matrix().isApprox(repeated.T_odom_submap.Matrix(), 1e-6)) {
    return false;
  }
  for (size_t i = 0; i < stored.points.size(); ++i) {
    const SubmapPoint& a = stored.points[i];
    const SubmapPoint& b = repeated.points[i];
    if (a.keyframe != b.keyframe ||
        (a.Position() - b.Position()).cwiseAbs().maxCoeff() > kSameCoordinateM) {
      return false;
    }
  }
  return true;
}

}  // namespace isthmus::ingest
