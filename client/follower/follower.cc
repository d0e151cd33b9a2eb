#include "client/follower/follower.h"

#include <utility>

#include "core/byte_stream.h"
#include "core/codec/quantized.h"
#include "core/codec/scan_decoder.h"
#include "core/scan_clock.h"
#include "floam/odometry.h"
#include "floam/odometry_options.h"
#include "floam/rings/sensor_model.h"
#include "floam/submap_builder.h"

namespace isthmus::follower {
namespace {

// Fields x y z intensity (float32), keyframe (uint16).
PointPayload CloudOf(const Submap& submap) {
  PointPayload cloud;
  cloud.width = static_cast<uint32_t>(submap.points.size());
  cloud.stride = 18;
  cloud.fields = {
      {"x", 0}, {"y", 4}, {"z", 8}, {"intensity", 12}, {"keyframe", 16, ScalarType::kUint16}};
  cloud.data.reserve(submap.points.size() * cloud.stride);
  for (const SubmapPoint& point : submap.points) {
    for (const float value : {point.x, point.y, point.z, point.intensity}) {
      AppendBytes(value, cloud.data);
    }
    AppendBytes(point.keyframe, cloud.data);
  }
  return cloud;
}

absl::StatusOr<SubmapUpload> UploadOf(const Submap& submap, double resolution_m) {
  SubmapUpload upload;
  upload.id = submap.id;
  upload.first_stamp_ns = submap.first_stamp_ns;
  upload.last_stamp_ns = submap.last_stamp_ns;
  upload.T_odom_submap = submap.T_odom_submap;
  for (const Keyframe& keyframe : submap.keyframes) {
    upload.keyframes.push_back({keyframe.stamp_ns, keyframe.T_submap_sensor});
  }
  upload.cloud = CloudOf(submap);
  if (resolution_m <= 0) return upload;
  absl::StatusOr<PointPayload> quantized = codec::Quantize(upload.cloud, resolution_m);
  if (!quantized.ok()) return quantized.status();
  upload.cloud = *std::move(quantized);
  return upload;
}

floam::OdometryOptions OdometryOptionsOf(const FollowerOptions& options) {
  floam::OdometryOptions odometry;
  if (options.odometry) odometry.mode = *options.odometry;
  odometry.R_base_sensor = options.T_base_sensor.rotation();
  return odometry;
}

floam::SubmapOptions SubmapOptionsOf(const FollowerOptions& options) {
  floam::SubmapOptions submaps;
  submaps.resolution_m = options.resolution_m;
  return submaps;
}

void Reject(const absl::Status& why, ScanAck& ack, ScanCounts& counts) {
  ack.outcome = ScanOutcome::kRejected;
  ack.reason = std::string(why.message());
  ack.tracking = Tracking::kLost;
  ++counts.rejected;
}

void Count(const floam::OdometryResult& result, ScanAck& ack, ScanCounts& counts) {
  ack.T_odom_sensor = result.T_odom_sensor;
  ack.covariance = result.covariance;
  ack.unobserved_translations = result.degeneracy.translations;
  ack.unobserved_rotations = result.degeneracy.rotations;
  ack.timing = {result.timing.features_ms, result.timing.matching_ms, result.timing.map_ms,
                result.timing.total_ms};
  switch (result.status) {
    case floam::TrackingStatus::kOk:
      ack.tracking = Tracking::kOk;
      ++counts.ok;
      break;
    case floam::TrackingStatus::kDegenerate:
      ack.tracking = Tracking::kDegenerate;
      ++counts.degenerate;
      break;
    case floam::TrackingStatus::kLost:
      ack.tracking = Tracking::kLost;
      ++counts.lost;
      break;
  }
}

}  // namespace

struct Follower::State {
  State(const floam::SensorModel& sensor, const FollowerOptions& options)
      : resolution_m(options.resolution_m),
        submaps(SubmapOptionsOf(options)),
        odometry(sensor, OdometryOptionsOf(options)) {
    Begin(1);
  }

  void Begin(uint32_t number) {
    segment = number;
    builder.emplace(SessionId(), RobotId(), submaps);
  }

  absl::Status HandOver(const std::shared_ptr<const Submap>& submap,
                        std::vector<FollowedSubmap>& completed) {
    if (submap == nullptr) return absl::OkStatus();
    absl::StatusOr<SubmapUpload> upload = UploadOf(*submap, resolution_m);
    if (!upload.ok()) return upload.status();
    completed.push_back({segment, *std::move(upload)});
    return absl::OkStatus();
  }

  absl::Status Remember(const std::shared_ptr<const Submap>& submap,
                        std::vector<FollowedSubmap>& completed) {
    if (submap != nullptr) odometry.Remember(*submap);
    return HandOver(submap, completed);
  }

  absl::Status Keep(const floam::OdometryResult& result, std::vector<FollowedSubmap>& completed) {
    const bool stepped = std::exchange(clock_stepped, false);
    absl::Status status;
    if (result.segment != segment) {
      // The odometry has forgotten the old segment, and must not be told of it again.
      status = HandOver(builder->Finish(), completed);
      Begin(result.segment);
    }
    // Stamps in a submap stay in order.
    if (status.ok() && (stepped || result.status == floam::TrackingStatus::kLost)) {
      status = Remember(builder->Finish(), completed);
    }
    return status.ok() ? Remember(builder->Add(result), completed) : status;
  }

  absl::StatusOr<floam::OdometryResult> Track(const PointPayload& payload, uint64_t sequence,
                                              int64_t end_stamp_ns) {
    const absl::StatusOr<ScanClock::Reading> reading = clock.Read(end_stamp_ns);
    if (!reading.ok()) return reading.status();
    absl::StatusOr<Scan> scan = decoder.Decode(payload, sequence, end_stamp_ns);
    if (!scan.ok()) return scan.status();
    scan->end_stamp_ns = reading->time_ns;
    absl::StatusOr<floam::OdometryResult> result = odometry.Process(*scan);
    if (!result.ok()) return result;
    clock.Advance(end_stamp_ns, reading->time_ns);
    clock_stepped = reading->stepped;
    result->stamp_ns = end_stamp_ns;
    return result;
  }

  const double resolution_m;
  const floam::SubmapOptions submaps;
  codec::ScanDecoder decoder;
  ScanClock clock;
  bool clock_stepped = false;  // At the last scan.
  floam::Odometry odometry;
  std::optional<floam::SubmapBuilder> builder;
  uint32_t segment = 1;
  ScanCounts counts;
};

Follower::Follower(std::unique_ptr<State> state) : state_(std::move(state)) {}
Follower::~Follower() = default;

absl::StatusOr<std::unique_ptr<Follower>> Follower::Create(const FollowerOptions& options) {
  const absl::StatusOr<floam::SensorModel> sensor = floam::FindSensorModel(options.sensor);
  if (!sensor.ok()) return sensor.status();
  return std::unique_ptr<Follower>(new Follower(std::make_unique<State>(*sensor, options)));
}

absl::StatusOr<FollowedScan> Follower::Take(const PointPayload& payload, uint64_t sequence,
                                            int64_t end_stamp_ns) {
  FollowedScan followed;
  ScanAck& ack = followed.ack;
  ack.sequence = sequence;
  ack.end_stamp_ns = end_stamp_ns;
  const auto result = state_->Track(payload, sequence, end_stamp_ns);
  if (result.ok()) {
    if (auto status = state_->Keep(*result, followed.submaps); !status.ok()) return status;
    Count(*result, ack, state_->counts);
  } else {
    Reject(result.status(), ack, state_->counts);
  }
  ack.segment = state_->segment;
  ack.scans = state_->counts;
  return followed;
}

absl::StatusOr<std::vector<FollowedSubmap>> Follower::Finish() {
  std::vector<FollowedSubmap> completed;
  if (auto status = state_->HandOver(state_->builder->Finish(), completed); !status.ok()) {
    return status;
  }
  return completed;
}

const ScanCounts& Follower::counts() const { return state_->counts; }
uint32_t Follower::segment() const { return state_->segment; }

}  // namespace isthmus::follower
