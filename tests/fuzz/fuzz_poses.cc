// Text of anybody, taken for a file of poses (TUM, KITTI, g2o), as `isthmus upload` reads it, for
// one of times, which stand beside scans and poses, and for the names of a folder's files, one per
// line.
#include <absl/strings/str_split.h>

#include <cstdint>
#include <cstdlib>
#include <string>
#include <vector>

#include "client/cloud_upload/cloud_poses.h"
#include "client/cloud_upload/pose_file.h"
#include "client/readers/folder/name_series.h"
#include "client/readers/folder/name_times.h"
#include "client/readers/folder/times_file.h"
#include "core/formats/kitti_poses.h"

namespace isthmus::cloud_upload {
namespace {

void PairWith(const PoseFile& file, const CloudSeries& clouds) {
  const auto poses = CloudPoses::Create(file, clouds, {});
  if (!poses.ok()) return;
  const StampedPose first = file.poses.front(), last = file.poses.back();
  for (const int64_t stamp_ns :
       {first.stamp_ns, last.stamp_ns, first.stamp_ns / 2 + last.stamp_ns / 2, int64_t{0},
        int64_t{1'700'000'000'000'000'000}}) {
    const auto pose = poses->Of(file.poses.size() / 2, stamp_ns);
    if (pose && !pose->pose.translation().allFinite()) std::abort();
  }
}

void TryPoses(const std::string& text) {
  const absl::StatusOr<PoseFile> file = ParsePoses(text);
  if (!file.ok()) return;
  if (file->poses.empty()) std::abort();
  for (const StampedPose& stamped : file->poses) {
    if (!stamped.pose.Matrix().allFinite()) std::abort();
  }
  PairWith(*file, {.has_stamps = true, .count = file->poses.size()});
  PairWith(*file, {.has_stamps = false, .count = file->poses.size()});
}

void TryNames(const std::string& text) {
  const std::vector<std::string> names = absl::StrSplit(text, '\n', absl::SkipEmpty());
  readers::NameSeries series = readers::FindSeries(names);
  const size_t count = series.order.size();
  if (count + series.left_out.size() != names.size()) std::abort();
  for (const size_t size : {series.Steps().size(), series.Counts().size()}) {
    if (size != 0 && size != count) std::abort();
  }
  const auto times = readers::OrderByTimes(series);
  if (times && times->stamps_ns.size() != count) std::abort();
}

}  // namespace
}  // namespace isthmus::cloud_upload

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  isthmus::cloud_upload::TryPoses(text);
  (void)isthmus::formats::ParseKittiPoses(text);
  (void)isthmus::readers::ParseTimes(text);
  isthmus::cloud_upload::TryNames(text);
  return 0;
}
