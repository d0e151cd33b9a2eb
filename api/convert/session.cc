#include "api/convert/session.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "api/convert/enum_table.h"
#include "api/convert/geometry.h"

namespace isthmus::convert {
namespace {

constexpr std::pair<Tracking, v1::Tracking> kTrackings[] = {
    {Tracking::kUnknown, v1::TRACKING_UNSPECIFIED},
    {Tracking::kOk, v1::TRACKING_OK},
    {Tracking::kDegenerate, v1::TRACKING_DEGENERATE},
    {Tracking::kLost, v1::TRACKING_LOST},
};

constexpr std::pair<OdometryMode, v1::Odometry> kOdometries[] = {
    {OdometryMode::kContinuous, v1::ODOMETRY_CONTINUOUS},
    {OdometryMode::kFloam, v1::ODOMETRY_FLOAM},
    {OdometryMode::kAloam, v1::ODOMETRY_ALOAM},
};

constexpr std::pair<ScanOutcome, v1::StreamScansResponse::Outcome> kOutcomes[] = {
    {ScanOutcome::kProcessed, v1::StreamScansResponse::PROCESSED},
    {ScanOutcome::kDuplicate, v1::StreamScansResponse::DUPLICATE},
    {ScanOutcome::kRejected, v1::StreamScansResponse::REJECTED},
    {ScanOutcome::kSkipped, v1::StreamScansResponse::SKIPPED},
};

constexpr std::pair<WhenBehind, v1::WhenBehind> kWhenBehinds[] = {
    {WhenBehind::kWait, v1::WHEN_BEHIND_WAIT},
    {WhenBehind::kKeepNewest, v1::WHEN_BEHIND_KEEP_NEWEST},
};

WhenBehind FromWhenBehind(v1::WhenBehind when_behind) {
  return FromMessage(kWhenBehinds, when_behind, WhenBehind::kWait);
}

std::optional<OdometryMode> FromOdometry(v1::Odometry odometry) {
  return FromMessage(kOdometries, odometry, std::optional<OdometryMode>());
}

// The choices that CreateSessionRequest and Session both have: the one place that names them.
template <typename Message>
void PutChoices(const SessionRequest& choices, Message& message) {
  message.set_robot(choices.robot.value());
  message.set_sensor(choices.sensor);
  *message.mutable_t_base_sensor() = ToMessage(choices.T_base_sensor);
  message.set_odometry(ToMessage(choices.odometry));
  message.set_when_behind(ToMessage(kWhenBehinds, choices.when_behind));
}

template <typename Message>
SessionRequest ChoicesOf(const Message& message) {
  SessionRequest choices;
  choices.robot = RobotId(message.robot());
  choices.sensor = message.sensor();
  if (message.has_t_base_sensor()) choices.T_base_sensor = FromMessage(message.t_base_sensor());
  choices.odometry = FromOdometry(message.odometry());
  choices.when_behind = FromWhenBehind(message.when_behind());
  return choices;
}

void AddSegments(const SessionStatus& status, v1::Session& message) {
  message.set_segment(status.record.segment);
  message.set_first_segment(status.record.first_segment.value());
  if (status.record.segment > 1) return;
  message.set_segments(status.segments);
  *message.mutable_scan_counts() = ToMessage(status.scans);
  message.set_lost_since_ns(status.lost_since_ns);
}

SessionRecord RecordOf(const v1::Session& session) {
  SessionRecord record{ChoicesOf(session)};
  record.id = SessionId(session.id());
  record.state =
      session.state() == v1::Session::FINISHED ? SessionState::kFinished : SessionState::kActive;
  record.created_ns = session.created_ns();
  record.finished_ns = session.finished_ns();
  record.segment = std::max(session.segment(), 1u);
  record.first_segment = SessionId(session.first_segment());
  return record;
}

}  // namespace

v1::Odometry ToMessage(const std::optional<OdometryMode>& mode) {
  return mode ? ToMessage(kOdometries, *mode) : v1::ODOMETRY_UNSPECIFIED;
}

absl::StatusOr<std::optional<OdometryMode>> Checked(v1::Odometry odometry) {
  const std::optional<OdometryMode> mode = FromOdometry(odometry);
  if (mode || odometry == v1::ODOMETRY_UNSPECIFIED) return mode;
  return absl::InvalidArgumentError(absl::StrCat("unknown odometry ", static_cast<int>(odometry),
                                                 "; known are ",
                                                 absl::StrJoin(OdometryModeNames(), ", ")));
}

v1::Tracking ToMessage(Tracking tracking) { return ToMessage(kTrackings, tracking); }

Tracking FromMessage(v1::Tracking tracking) {
  return FromMessage(kTrackings, tracking, Tracking::kUnknown);
}

v1::CreateSessionRequest ToMessage(const SessionRequest& request) {
  v1::CreateSessionRequest message;
  PutChoices(request, message);
  message.set_request_id(request.request_id);
  return message;
}

absl::StatusOr<SessionRequest> FromMessage(const v1::CreateSessionRequest& request) {
  SessionRequest record = ChoicesOf(request);
  record.request_id = request.request_id();
  const auto odometry = Checked(request.odometry());
  if (!odometry.ok()) return odometry.status();
  if (record.when_behind == WhenBehind::kWait &&
      request.when_behind() != v1::WHEN_BEHIND_UNSPECIFIED &&
      request.when_behind() != v1::WHEN_BEHIND_WAIT) {
    return absl::InvalidArgumentError(absl::StrCat("unknown when_behind ",
                                                   static_cast<int>(request.when_behind()),
                                                   "; known are wait (1) and keep newest (2)"));
  }
  if (request.has_t_base_sensor()) {
    const auto pose = Checked(request.t_base_sensor(), "t_base_sensor");
    if (!pose.ok()) return pose.status();
    record.T_base_sensor = *pose;
  }
  return record;
}

v1::Session ToMessage(const SessionStatus& status) {
  v1::Session message;
  const SessionRecord& record = status.record;
  message.set_id(record.id.value());
  PutChoices(record, message);
  message.set_state(record.state == SessionState::kActive ? v1::Session::ACTIVE
                                                          : v1::Session::FINISHED);
  message.set_created_ns(record.created_ns);
  message.set_finished_ns(record.finished_ns);
  message.set_last_sequence(status.last_sequence);
  message.set_durable_sequence(status.durable_sequence);
  message.set_scans_processed(status.scans_processed);
  message.set_scans_rejected(status.scans_rejected);
  message.set_submap_count(status.submap_count);
  message.set_point_count(status.point_count);
  message.set_odometry_ms_mean(status.odometry_ms_mean);
  message.set_travelled_m(status.travelled_m);
  message.set_tracking(ToMessage(kTrackings, status.tracking));
  message.set_input(status.input);
  message.set_map_bytes(status.map_bytes);
  message.set_scan_bytes(status.scan_bytes);
  message.set_quota_bytes(status.quota_bytes);
  message.set_archive_problem(status.archive_problem);
  message.set_quantized_version(status.quantized_version);
  AddSegments(status, message);
  if (status.component) message.set_component(*status.component);
  if (status.T_map_odom) *message.mutable_t_map_odom() = ToMessage(*status.T_map_odom);
  return message;
}

SessionStatus FromMessage(const v1::Session& session) {
  SessionStatus status;
  status.record = RecordOf(session);
  status.last_sequence = session.last_sequence();
  status.durable_sequence = session.durable_sequence();
  status.scans_processed = session.scans_processed();
  status.scans_rejected = session.scans_rejected();
  status.submap_count = session.submap_count();
  status.point_count = session.point_count();
  status.odometry_ms_mean = session.odometry_ms_mean();
  status.travelled_m = session.travelled_m();
  status.tracking = FromMessage(kTrackings, session.tracking(), Tracking::kUnknown);
  status.input = session.input();
  status.map_bytes = session.map_bytes();
  status.scan_bytes = session.scan_bytes();
  status.quota_bytes = session.quota_bytes();
  status.archive_problem = session.archive_problem();
  status.quantized_version = session.quantized_version();
  status.segments = std::max(session.segments(), 1u);
  status.scans = FromMessage(session.scan_counts());
  status.lost_since_ns = session.lost_since_ns();
  if (session.has_component()) status.component = session.component();
  if (session.has_t_map_odom()) status.T_map_odom = FromMessage(session.t_map_odom());
  return status;
}

v1::ScanCounts ToMessage(const ScanCounts& counts) {
  v1::ScanCounts message;
  message.set_ok(counts.ok);
  message.set_degenerate(counts.degenerate);
  message.set_lost(counts.lost);
  message.set_rejected(counts.rejected);
  message.set_skipped(counts.skipped);
  return message;
}

ScanCounts FromMessage(const v1::ScanCounts& counts) {
  return {counts.ok(), counts.degenerate(), counts.lost(), counts.rejected(), counts.skipped()};
}

v1::StreamScansResponse ToMessage(const ScanAck& ack) {
  v1::StreamScansResponse message;
  message.set_durable_sequence(ack.durable_sequence);
  if (ack.sequence == 0) return message;
  message.set_sequence(ack.sequence);
  message.set_outcome(ToMessage(kOutcomes, ack.outcome));
  message.set_reason(ack.reason);
  message.set_tracking(ToMessage(kTrackings, ack.tracking));
  if (ack.T_odom_sensor) *message.mutable_t_odom_sensor() = ToMessage(*ack.T_odom_sensor);
  if (ack.T_map_odom) *message.mutable_t_map_odom() = ToMessage(*ack.T_map_odom);
  message.set_segment(ack.segment);
  message.set_segment_session(ack.segment_session.value());
  message.set_lost_since_ns(ack.lost_since_ns);
  *message.mutable_scan_counts() = ToMessage(ack.scans);
  if (ack.covariance) AddUpperTriangle(*ack.covariance, message.mutable_covariance());
  for (const Eigen::Vector3d& direction : ack.unobserved_translations) {
    *message.add_unobserved_translations() = ToMessage(direction);
  }
  for (const Eigen::Vector3d& axis : ack.unobserved_rotations) {
    *message.add_unobserved_rotations() = ToMessage(axis);
  }
  if (ack.outcome == ScanOutcome::kProcessed) {
    v1::ScanTiming& timing = *message.mutable_timing();
    timing.set_features_ms(ack.timing.features_ms);
    timing.set_matching_ms(ack.timing.matching_ms);
    timing.set_map_ms(ack.timing.map_ms);
    timing.set_total_ms(ack.timing.total_ms);
  }
  return message;
}

ScanAck FromMessage(const v1::StreamScansResponse& ack) {
  ScanAck record;
  record.sequence = ack.sequence();
  record.outcome = FromMessage(kOutcomes, ack.outcome(), ScanOutcome::kProcessed);
  record.reason = ack.reason();
  record.tracking = FromMessage(kTrackings, ack.tracking(), Tracking::kUnknown);
  if (ack.has_t_odom_sensor()) record.T_odom_sensor = FromMessage(ack.t_odom_sensor());
  if (ack.has_t_map_odom()) record.T_map_odom = FromMessage(ack.t_map_odom());
  record.segment = ack.segment();
  record.segment_session = SessionId(ack.segment_session());
  record.lost_since_ns = ack.lost_since_ns();
  record.scans = FromMessage(ack.scan_counts());
  record.durable_sequence = ack.durable_sequence();
  record.covariance = FromUpperTriangle(ack.covariance());
  for (const v1::Vector3& direction : ack.unobserved_translations()) {
    record.unobserved_translations.push_back(FromMessage(direction));
  }
  for (const v1::Vector3& axis : ack.unobserved_rotations()) {
    record.unobserved_rotations.push_back(FromMessage(axis));
  }
  record.timing = {ack.timing().features_ms(), ack.timing().matching_ms(), ack.timing().map_ms(),
                   ack.timing().total_ms()};
  return record;
}

}  // namespace isthmus::convert
