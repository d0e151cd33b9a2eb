#include "client/cloud_upload/cloud_poses.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <utility>

namespace isthmus::cloud_upload {
namespace {

bool IsEarlier(const StampedPose& a, const StampedPose& b) { return a.stamp_ns < b.stamp_ns; }

// True if the i-th pose can be that of the i-th cloud. An unknown number of clouds is taken to fit.
bool HaveSameNumber(const CloudSeries& clouds, size_t poses) {
  if (!clouds.count) return true;
  const size_t end = clouds.first + *clouds.count;
  return clouds.is_part ? poses >= end : poses == end;
}

absl::Status CannotPair(const PoseFile& file, const CloudSeries& clouds) {
  const std::string numbers =
      absl::StrCat(file.poses.size(), " poses for ", clouds.first + clouds.count.value_or(0),
                   " clouds cannot be paired in order, and ");
  if (!clouds.has_stamps) {
    return absl::InvalidArgumentError(
        absl::StrCat(numbers,
                     "the clouds have no times: put a times.txt beside them, a line in "
                     "seconds for each, or name the files by their times"));
  }
  return absl::InvalidArgumentError(absl::StrCat(
      numbers, "the ", ToString(file.format),
      file.format == PoseFormat::kKitti
          ? " file has no times: put a times.txt beside it, a line in seconds for each pose"
          : " file has no times: write its poses as TUM, a stamp before each"));
}

}  // namespace

std::optional<Pose> PoseAt(const Trajectory& sorted, int64_t stamp_ns,
                           const AssociationOptions& options) {
  const auto after =
      std::lower_bound(sorted.begin(), sorted.end(), StampedPose{stamp_ns, {}}, IsEarlier);
  if (after != sorted.end() && after->stamp_ns == stamp_ns) return after->pose;
  const bool has_before = after != sorted.begin(), has_after = after != sorted.end();
  const StampedPose* before = has_before ? &*std::prev(after) : nullptr;
  if (has_before && has_after && after->stamp_ns - before->stamp_ns <= options.interpolated_ns) {
    const double fraction = static_cast<double>(stamp_ns - before->stamp_ns) /
                            static_cast<double>(after->stamp_ns - before->stamp_ns);
    return Interpolate(before->pose, after->pose, fraction);
  }
  const bool is_after =
      has_after && (!has_before || after->stamp_ns - stamp_ns < stamp_ns - before->stamp_ns);
  if (!is_after && !has_before) return std::nullopt;
  const StampedPose& nearest = is_after ? *after : *before;
  if (std::abs(nearest.stamp_ns - stamp_ns) > options.nearest_ns) return std::nullopt;
  return nearest.pose;
}

absl::StatusOr<CloudPoses> CloudPoses::Create(PoseFile file, const CloudSeries& clouds,
                                              const AssociationOptions& options) {
  const bool by_stamp = clouds.has_stamps && file.has_stamps;
  const bool fits = HaveSameNumber(clouds, file.poses.size());
  if (!by_stamp && !fits) return CannotPair(file, clouds);
  CloudPoses made;
  made.options_ = options;
  // A times.txt beside KITTI's poses is that of the clouds: where it names one for each, that each
  // has its own is certain, and that stamps agree is not.
  made.in_order_ = !by_stamp || (file.format != PoseFormat::kTum && clouds.count && fits);
  made.takes_stamps_ = file.has_stamps && !clouds.has_stamps;
  made.poses_ = std::move(file.poses);
  if (!made.in_order_) std::stable_sort(made.poses_.begin(), made.poses_.end(), IsEarlier);
  return made;
}

std::optional<StampedPose> CloudPoses::Of(size_t index, int64_t stamp_ns) const {
  if (!in_order_) {
    const std::optional<Pose> pose = PoseAt(poses_, stamp_ns, options_);
    return pose ? std::optional(StampedPose{stamp_ns, *pose}) : std::nullopt;
  }
  if (index >= poses_.size()) return std::nullopt;
  return StampedPose{takes_stamps_ ? poses_[index].stamp_ns : stamp_ns, poses_[index].pose};
}

}  // namespace isthmus::cloud_upload
