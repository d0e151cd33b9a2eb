#include "server/localisation/robot_localiser.h"

#include <future>
#include <optional>
#include <string>
#include <utility>

#include "core/caught.h"
#include "core/codec/scan_decoder.h"
#include "core/scan_clock.h"
#include "floam/localise/localiser.h"

namespace isthmus::localisation {
namespace {

Tracking TrackingOf(floam::TrackingStatus status) {
  return status == floam::TrackingStatus::kOk           ? Tracking::kOk
         : status == floam::TrackingStatus::kDegenerate ? Tracking::kDegenerate
                                                        : Tracking::kLost;
}

LocalisationState StateOf(floam::LocalisationStatus status) {
  switch (status) {
    case floam::LocalisationStatus::kSearching:
      return LocalisationState::kSearching;
    case floam::LocalisationStatus::kAmbiguous:
      return LocalisationState::kAmbiguous;
    case floam::LocalisationStatus::kLocated:
      return LocalisationState::kLocated;
    case floam::LocalisationStatus::kUncertain:
      return LocalisationState::kUncertain;
  }
  return LocalisationState::kSearching;
}

class Localisation : public server::RobotLocaliser {
 public:
  Localisation(const floam::SensorModel& sensor, const floam::OdometryOptions& options,
               RobotId in_map_of, LocalisationMaps* maps, Executor* executor,
               const std::atomic<bool>* shut_down)
      : localiser_(sensor, options),
        in_map_of_(std::move(in_map_of)),
        maps_(*maps),
        executor_(*executor),
        shut_down_(*shut_down) {}

  // As LocalisationMaps::Get; where the map as it was lasts, that is kept.
  absl::Status TakeMap() {
    const auto map = maps_.Get(in_map_of_);
    if (!map.ok()) return map_ == nullptr ? map.status() : absl::OkStatus();
    if (*map == map_) return absl::OkStatus();
    std::optional<Pose> motion;
    if (map_ != nullptr && T_map_sensor_) {
      motion = MotionBetween(*map_, **map, T_map_sensor_->translation());
    }
    if (motion) {
      localiser_.SetMap((*map)->map, *motion);
    } else {
      localiser_.SetMapAnew((*map)->map);
    }
    map_ = *map;
    return absl::OkStatus();
  }

  void Enter(LocalisingRobots* robots, const RobotId& robot) { member_ = robots->Enter(robot); }

  absl::StatusOr<LocalisedScan> Locate(const ScanUpload& scan) override {
    if (shut_down_) return absl::UnavailableError("the server is shutting down");
    member_->NoteScan();
    std::promise<absl::StatusOr<LocalisedScan>> promise;
    executor_.Post(lane_, [&] {
      try {
        promise.set_value(LocateNow(scan));
      } catch (...) {
        promise.set_value(CaughtStatus());
      }
    });
    auto located = promise.get_future().get();
    if (located.ok()) member_->NotePlace(*located, scan.end_stamp_ns);
    return located;
  }

 private:
  absl::StatusOr<LocalisedScan> LocateNow(const ScanUpload& upload) {
    LocalisedScan located;
    located.sequence = upload.sequence;
    if (absl::Status status = TakeMap(); !status.ok()) return status;
    located.revision = map_->revision;
    located.component = map_->component;
    auto result = Follow(upload);
    if (!result.ok()) {
      located.rejected = std::string(result.status().message());
      located.tracking = Tracking::kLost;
      return located;
    }
    located.state = StateOf(result->status);
    located.tracking = TrackingOf(result->odometry.status);
    located.segment = result->odometry.segment;
    located.T_odom_sensor = result->odometry.T_odom_sensor;
    located.odometry_ms = result->odometry.timing.total_ms;
    located.localising_ms = result->localising_ms;
    T_map_sensor_.reset();
    if (!result->has_pose()) return located;
    T_map_sensor_ = located.T_map_sensor = result->T_map_sensor;
    located.T_map_odom = result->T_map_odom;
    located.covariance = result->covariance;
    return located;
  }

  absl::StatusOr<floam::LocalisationResult> Follow(const ScanUpload& upload) {
    const auto reading = clock_.Read(upload.end_stamp_ns);
    if (!reading.ok()) return reading.status();
    auto scan = decoder_.Decode(upload.payload, upload.sequence, upload.end_stamp_ns);
    if (!scan.ok()) return scan.status();
    scan->end_stamp_ns = reading->time_ns;
    auto result = localiser_.Process(*scan);
    if (result.ok()) clock_.Advance(upload.end_stamp_ns, reading->time_ns);
    return result;
  }

  codec::ScanDecoder decoder_;
  ScanClock clock_;
  floam::Localiser localiser_;
  const RobotId in_map_of_;
  LocalisationMaps& maps_;
  Executor& executor_;
  const std::shared_ptr<Executor::Lane> lane_ = Executor::MakeLane();
  const std::atomic<bool>& shut_down_;
  std::shared_ptr<const PlacedMap> map_;
  std::optional<Pose> T_map_sensor_;  // The last scan's, if it is known.
  std::unique_ptr<LocalisingRobots::Member> member_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<server::RobotLocaliser>> MakeRobotLocaliser(
    const floam::SensorModel& sensor, const floam::OdometryOptions& options,
    const LocalisationRequest& request, LocalisationMaps* maps, LocalisingRobots* robots,
    Executor* executor, const std::atomic<bool>* shut_down) {
  auto localisation =
      std::make_unique<Localisation>(sensor, options, request.in_map_of, maps, executor, shut_down);
  if (absl::Status status = localisation->TakeMap(); !status.ok()) return status;
  localisation->Enter(robots, request.robot);
  return localisation;
}

}  // namespace isthmus::localisation
