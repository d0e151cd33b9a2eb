#include "client/offline/merge/merge_input.h"

#include <absl/strings/ascii.h>
#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <numeric>
#include <set>
#include <utility>

#include "client/cloud_upload/limits.h"
#include "client/offline/merge/guessed_viewpoints.h"
#include "client/offline/merge/viewpoints.h"
#include "core/codec/payload_layout.h"
#include "core/formats/cloud_file.h"
#include "core/formats/pcd.h"
#include "core/formats/tum.h"
#include "core/geometry/near_origin.h"
#include "server/threads/limits.h"
#include "storage/record_rules.h"

namespace isthmus::cli {
namespace {

// The server takes kMaxScanPoints in one submap.
constexpr size_t kMaxSubmapPoints = 2'000'000;
constexpr double kViewpointDistanceM = 1;

bool IsEarlier(const StampedPose& a, const StampedPose& b) { return a.stamp_ns < b.stamp_ns; }

// The poses from which the map was seen, in order of time, thinned. Empty when nothing tells.
absl::StatusOr<Trajectory> Viewpoints(const std::string& file, std::vector<std::string>& notes) {
  const std::string beside = TrajectoryBeside(file);
  std::error_code error;
  if (!std::filesystem::exists(beside, error)) return Trajectory{};
  absl::StatusOr<Trajectory> poses = formats::ReadTum(beside);
  if (!poses.ok()) return poses.status();
  if (poses->empty()) return absl::InvalidArgumentError(absl::StrCat(beside, " holds no poses"));
  if (!std::is_sorted(poses->begin(), poses->end(), IsEarlier)) {
    std::stable_sort(poses->begin(), poses->end(), IsEarlier);
    notes.push_back(absl::StrCat(beside, " is not in order of time: its poses were sorted"));
  }
  return Thin(*poses, kViewpointDistanceM);
}

// InvalidArgument where the sensor cannot have seen the map from there.
absl::Status CheckSight(const std::string& file, bool is_trajectory, const Cloud& points,
                        const Trajectory& viewpoints) {
  const double nearest_m = NearestM(points, viewpoints);
  if (nearest_m <= kSightM) return absl::OkStatus();
  const std::string beside = TrajectoryBeside(file);
  return absl::InvalidArgumentError(absl::StrFormat(
      "%s %.0f m from the nearest point, and a sensor sees %.0f m. Give %s, the robot's trajectory "
      "in the frame of the map",
      is_trajectory ? absl::StrCat(beside, " does not fit ", file, ": its nearest pose is")
                    : absl::StrCat(file, ": its VIEWPOINT is"),
      nearest_m, kSightM, beside));
}

// A submap as it grows.
class SubmapMaker {
 public:
  SubmapMaker() {
    upload_.cloud.fields = {{"x", 0, ScalarType::kFloat32, 1},
                            {"y", 4, ScalarType::kFloat32, 1},
                            {"z", 8, ScalarType::kFloat32, 1},
                            {"intensity", 12, ScalarType::kFloat32, 1},
                            {"keyframe", 16, ScalarType::kUint32, 1}};
    upload_.cloud.stride = 20;
  }

  void AddKeyframe(const StampedPose& keyframe) {
    if (upload_.keyframes.empty()) upload_.first_stamp_ns = keyframe.stamp_ns;
    upload_.last_stamp_ns = keyframe.stamp_ns;
    upload_.keyframes.push_back(keyframe);
  }
  // Adds a point of the keyframe added last.
  void AddPoint(const Point& point) {
    const float values[4] = {point.x, point.y, point.z, point.intensity};
    const uint32_t keyframe = static_cast<uint32_t>(upload_.keyframes.size() - 1);
    upload_.cloud.data.append(reinterpret_cast<const char*>(values), sizeof(values));
    upload_.cloud.data.append(reinterpret_cast<const char*>(&keyframe), sizeof(keyframe));
    ++upload_.cloud.width;
  }
  size_t points() const { return upload_.cloud.width; }
  SubmapUpload Take() { return std::exchange(*this, SubmapMaker()).upload_; }

 private:
  SubmapUpload upload_;
};

// Numbers of the stretches of way that the viewpoints lie on, each as long as that of a submap.
std::vector<size_t> Stretches(const Trajectory& viewpoints) {
  std::vector<size_t> stretches(viewpoints.size(), 0);
  double way_m = 0;
  int64_t begun_ns = viewpoints.front().stamp_ns;
  for (size_t k = 1; k < viewpoints.size(); ++k) {
    way_m += (viewpoints[k].pose.translation() - viewpoints[k - 1].pose.translation()).norm();
    const int64_t taken_ns = viewpoints[k].stamp_ns - begun_ns;
    const bool is_full = way_m >= cloud_upload::kSubmapWayM ||
                         1e-9 * static_cast<double>(taken_ns) >= cloud_upload::kSubmapTimeS;
    stretches[k] = stretches[k - 1] + (is_full ? 1 : 0);
    if (!is_full) continue;
    way_m = 0;
    begun_ns = viewpoints[k].stamp_ns;
  }
  return stretches;
}

// Calls `take(point, stretch)` for the stretches that each point is visible from, each once and in
// order.
template <typename Take>
void ForStretches(const std::vector<size_t>& stretches, size_t points,
                  const std::vector<std::vector<uint32_t>>& visible, const Take& take) {
  std::vector<size_t> last(points, std::numeric_limits<size_t>::max());
  for (size_t k = 0; k < visible.size(); ++k) {
    for (const uint32_t point : visible[k]) {
      if (std::exchange(last[point], stretches[k]) != stretches[k]) take(point, stretches[k]);
    }
  }
}

// Leaves every point to one of the stretches that it is visible from, to each in turn. Stretches
// then share no point, as submaps of a drive share none, and how well surfaces of the map agree
// with each other can be measured.
void DealOut(const std::vector<size_t>& stretches, size_t points,
             std::vector<std::vector<uint32_t>>& visible) {
  std::vector<uint32_t> count(points, 0), turn(points, 0);
  ForStretches(stretches, points, visible, [&](uint32_t point, size_t) { ++count[point]; });
  std::vector<size_t> owner(points, 0);
  ForStretches(stretches, points, visible, [&](uint32_t point, size_t stretch) {
    if (turn[point]++ == point % count[point]) owner[point] = stretch;
  });
  for (size_t k = 0; k < visible.size(); ++k) {
    std::erase_if(visible[k], [&](uint32_t point) { return owner[point] != stretches[k]; });
  }
}

// `stretches` as many as keyframes: where the number changes, a submap ends.
std::vector<SubmapUpload> MakeSubmaps(const Cloud& points, const Trajectory& keyframes,
                                      const std::vector<size_t>& stretches,
                                      const std::vector<std::vector<uint32_t>>& visible) {
  std::vector<SubmapUpload> submaps;
  SubmapMaker maker;
  for (size_t k = 0; k < keyframes.size(); ++k) {
    if (k > 0 && stretches[k] != stretches[k - 1] && maker.points() > 0) {
      submaps.push_back(maker.Take());
    }
    if (visible[k].empty()) continue;
    maker.AddKeyframe(keyframes[k]);
    for (const uint32_t index : visible[k]) {
      if (maker.points() == kMaxSubmapPoints) {
        submaps.push_back(maker.Take());
        maker.AddKeyframe(keyframes[k]);
      }
      maker.AddPoint(points[index]);
    }
  }
  if (maker.points() > 0) submaps.push_back(maker.Take());
  return submaps;
}

// Two keyframes for each viewpoint. Matching takes the view of the first one; the second, at the
// same pose, holds points that are in no view.
Trajectory EachTwice(const Trajectory& viewpoints) {
  Trajectory keyframes;
  for (const StampedPose& viewpoint : viewpoints) keyframes.insert(keyframes.end(), 2, viewpoint);
  return keyframes;
}

// Only a PCD tells a viewpoint.
absl::StatusOr<formats::PcdFile> ReadMap(const std::string& file) {
  if (absl::EqualsIgnoreCase(std::filesystem::path(file).extension().string(), ".pcd")) {
    return formats::ReadPcd(file);
  }
  absl::StatusOr<PointPayload> cloud = formats::ReadCloudFile(file);
  if (!cloud.ok()) return cloud.status();
  return formats::PcdFile{*std::move(cloud), {}, {}};
}

// The points near the origin, and notes of what became of the others.
absl::StatusOr<Cloud> ReadPoints(const PointPayload& payload, MergeInput& input) {
  absl::StatusOr<Cloud> points = FinitePoints(payload, &input.moved_by);
  if (!points.ok()) {
    return absl::InvalidArgumentError(absl::StrCat(input.file, ": ", points.status().message()));
  }
  input.points = points->size();
  if (input.points < server::kLeastMatchedPoints) {
    return absl::InvalidArgumentError(absl::StrCat(
        input.file, ": ", input.points, input.points == 1 ? " point is" : " points are",
        " too few to match: a map has at least ", server::kLeastMatchedPoints));
  }
  if (const size_t all = codec::PointCount(payload); all > input.points) {
    input.notes.push_back(absl::StrCat(input.file, ": ", all - input.points, " of ", all,
                                       " points are left out: they are not finite"));
  }
  if (!input.moved_by.isZero()) input.notes.push_back(ShiftText(input.file, input.moved_by));
  return points;
}

absl::StatusOr<MergeInput> ReadMergeInput(const std::string& file) {
  const absl::StatusOr<formats::PcdFile> pcd = ReadMap(file);
  if (!pcd.ok()) return pcd.status();
  MergeInput input;
  input.file = file;
  absl::StatusOr<Trajectory> viewpoints = Viewpoints(file, input.notes);
  if (!viewpoints.ok()) return viewpoints.status();
  const absl::StatusOr<Cloud> points = ReadPoints(pcd->payload, input);
  if (!points.ok()) return points.status();
  const bool has_trajectory = !viewpoints->empty();
  if (!has_trajectory && !pcd->viewpoint.Matrix().isIdentity(1e-6)) {
    *viewpoints = {{0, pcd->viewpoint}};
  }
  const Pose T_near_file(input.moved_by);
  for (StampedPose& viewpoint : *viewpoints) viewpoint.pose = T_near_file * viewpoint.pose;
  input.viewpoints = viewpoints->size();
  if (input.viewpoints > 0) {
    const absl::Status status = CheckSight(file, has_trajectory, *points, *viewpoints);
    if (!status.ok()) return status;
  } else {
    *viewpoints = GuessViewpoints(*points);
  }
  if (viewpoints->empty()) *viewpoints = {{0, Pose()}};
  std::vector<std::vector<uint32_t>> visible;
  if (viewpoints->size() == 1) {
    visible.emplace_back(points->size());
    std::iota(visible[0].begin(), visible[0].end(), 0);
  } else {
    visible = VisiblePoints(*points, *viewpoints);
    *viewpoints = EachTwice(*viewpoints);
  }
  // Guessed viewpoints are on no way.
  std::vector<size_t> stretches(viewpoints->size(), 0);
  if (input.viewpoints > 0) stretches = Stretches(*viewpoints);
  DealOut(stretches, points->size(), visible);
  input.submaps = MakeSubmaps(*points, *viewpoints, stretches, visible);
  return input;
}

// `index` is that of the file.
absl::Status RefusePoint(size_t index, const Eigen::Vector3d& point,
                         const Eigen::Vector3d& origin) {
  return absl::InvalidArgumentError(absl::StrFormat(
      "point %d, counted from 0, is at %.1f %.1f %.1f. Give metres, without points more than "
      "%.0f m from %.0f %.0f %.0f",
      index, point.x(), point.y(), point.z(), storage::kMaxCoordinateM, origin.x(), origin.y(),
      origin.z()));
}

}  // namespace

absl::StatusOr<Cloud> FinitePoints(const PointPayload& payload, Eigen::Vector3d* moved_by) {
  if (absl::Status status = codec::CheckRawLayout(payload); !status.ok()) return status;
  std::vector<std::vector<double>> xyz;
  for (const char* name : {"x", "y", "z"}) {
    const PointField* field = codec::FindField(payload, {name});
    if (field == nullptr) return absl::InvalidArgumentError(absl::StrCat("no field ", name));
    xyz.push_back(codec::ReadColumn(payload, *field));
  }
  std::vector<double> intensity(xyz[0].size(), 0);
  if (const PointField* field = codec::FindField(payload, {"intensity", "i", "reflectivity"})) {
    intensity = codec::ReadColumn(payload, *field);
  }
  const Eigen::Vector3d shift = ShiftToOrigin(MiddleOf(xyz[0], xyz[1], xyz[2]));
  if (moved_by != nullptr) *moved_by = shift;
  Cloud points;
  for (size_t i = 0; i < xyz[0].size(); ++i) {
    const Point point{static_cast<float>(xyz[0][i] + shift.x()),
                      static_cast<float>(xyz[1][i] + shift.y()),
                      static_cast<float>(xyz[2][i] + shift.z()), static_cast<float>(intensity[i])};
    if (!point.Position().allFinite()) continue;
    if (point.Position().cwiseAbs().maxCoeff() > storage::kMaxCoordinateM) {
      return RefusePoint(i, {xyz[0][i], xyz[1][i], xyz[2][i]}, Eigen::Vector3d::Zero() - shift);
    }
    points.push_back(point);
  }
  if (points.empty()) return absl::InvalidArgumentError("no point with finite coordinates");
  return points;
}

std::string TrajectoryBeside(const std::string& file) {
  return std::filesystem::path(file).replace_extension(".tum").string();
}

std::string UniqueRobotName(const std::string& path, std::set<std::string>& taken) {
  std::string name = std::filesystem::path(path).stem().string().substr(0, 56);
  for (char& c : name) {
    if (!absl::ascii_isalnum(c) && c != '_' && c != '.' && c != '-') c = '_';
  }
  if (name.empty()) name = "map";
  std::string unique = name;
  for (int i = 2; !taken.insert(unique).second; ++i) unique = absl::StrCat(name, "-", i);
  return unique;
}

absl::StatusOr<std::vector<MergeInput>> ReadMergeInputs(const std::vector<std::string>& files,
                                                        std::set<std::string>& names) {
  std::vector<MergeInput> inputs;
  for (const std::string& file : files) {
    absl::StatusOr<MergeInput> input = ReadMergeInput(file);
    if (!input.ok()) return input.status();
    input->robot = UniqueRobotName(file, names);
    inputs.push_back(*std::move(input));
  }
  return inputs;
}

}  // namespace isthmus::cli
