#include "server/rpc/stream_scans.h"

#include <absl/cleanup/cleanup.h>
#include <absl/strings/str_cat.h>

#include <memory>
#include <utility>

#include "core/executor.h"
#include "server/rpc/convert.h"

namespace isthmus::rpc {
namespace {

using rpc::ToProto;  // Else hidden by the overloads below.

v1::StreamScansResponse::Outcome ToProto(ScanOutcome outcome) {
  switch (outcome) {
    case ScanOutcome::kProcessed:
      return v1::StreamScansResponse::PROCESSED;
    case ScanOutcome::kDuplicate:
      return v1::StreamScansResponse::DUPLICATE;
    case ScanOutcome::kRejected:
      return v1::StreamScansResponse::REJECTED;
  }
  return v1::StreamScansResponse::OUTCOME_UNSPECIFIED;
}

v1::StreamScansResponse ToProto(const ScanAck& ack) {
  v1::StreamScansResponse proto;
  proto.set_durable_sequence(ack.durable_sequence);
  if (ack.sequence == 0) return proto;
  proto.set_sequence(ack.sequence);
  proto.set_outcome(ToProto(ack.outcome));
  proto.set_reason(ack.reason);
  proto.set_tracking(ack.status);
  if (ack.T_odom_sensor) *proto.mutable_t_odom_sensor() = ToProto(*ack.T_odom_sensor);
  if (ack.T_map_odom) *proto.mutable_t_map_odom() = ToProto(*ack.T_map_odom);
  proto.set_segment(ack.segment);
  proto.set_segment_session(ack.segment_session.value());
  proto.set_lost_since_ns(ack.lost_since_ns);
  *proto.mutable_scan_counts() = ToProto(ack.scans);
  if (ack.covariance) AddUpperTriangle(*ack.covariance, proto.mutable_covariance());
  for (const Eigen::Vector3d& d : ack.unobserved_translations) {
    *proto.add_unobserved_translations() = ToProto(d);
  }
  for (const Eigen::Vector3d& d : ack.unobserved_rotations) {
    *proto.add_unobserved_rotations() = ToProto(d);
  }
  if (ack.outcome == ScanOutcome::kProcessed) {
    v1::ScanTiming& timing = *proto.mutable_timing();
    timing.set_features_ms(ack.features_ms);
    timing.set_matching_ms(ack.matching_ms);
    timing.set_map_ms(ack.map_ms);
    timing.set_total_ms(ack.total_ms);
  }
  return proto;
}

absl::Status Submit(server::Pipeline& pipeline, const SessionId& session, AckWindow& window,
                    v1::ScanMessage&& message) {
  server::ScanUpload scan;
  scan.sequence = message.sequence();
  scan.end_stamp_ns = message.end_stamp_ns();
  if (scan.sequence == 0) {
    return absl::InvalidArgumentError("a scan has sequence 0: sequences count from 1");
  }
  auto payload = FromProto(std::move(*message.mutable_cloud()));
  // A scan that cannot even be expressed goes on as an empty cloud, so that its sequence is used up
  // and its rejection comes in order; the reason given is ours.
  std::string reason;
  if (payload.ok()) {
    scan.payload = *std::move(payload);
  } else {
    reason = std::string(payload.status().message());
  }
  window.Expect(scan.sequence, std::move(reason));
  const uint64_t sequence = scan.sequence;
  const absl::Status status = pipeline.SubmitScan(session, std::move(scan));
  if (!status.ok()) window.Withdraw(sequence);
  return status;
}

// `request` holds the first message.
absl::Status ReadScans(server::Pipeline& pipeline, const SessionId& session, AckWindow& window,
                       const ScanLink& link, v1::StreamScansRequest& request) {
  do {
    if (!request.session().empty() && request.session() != session.value()) {
      return absl::InvalidArgumentError(absl::StrCat("the stream is of session \"", session.value(),
                                                     "\" but a message names \"", request.session(),
                                                     "\": open another stream for it"));
    }
    if (request.has_scan()) {
      absl::Status status = Submit(pipeline, session, window, std::move(*request.mutable_scan()));
      if (!status.ok()) return status;
    }
    if (!window.WaitForRoom()) {
      return absl::UnavailableError("the server ends this stream; open another one");
    }
  } while (link.read(&request));
  return absl::OkStatus();
}

void WriteAcks(AckWindow& window, const ScanLink& link) {
  const absl::Cleanup end = [&] {
    window.Close();
    // Stopped or broken while the reader waits for the robot's next message: wake it. Not after the
    // last scan, where it would turn the stream's status into CANCELLED.
    if (!window.scans_ended()) link.cancel();
  };
  while (const auto ack = window.Next()) {
    if (!link.write(ToProto(*ack))) break;
  }
}

}  // namespace

absl::Status StreamScans(server::Pipeline& pipeline, ScanStreams& streams, const ScanLink& link) {
  v1::StreamScansRequest request;
  if (!link.read(&request) || request.session().empty()) {
    return absl::InvalidArgumentError("the first message of the stream must name its session");
  }
  const SessionId session(request.session());
  auto seat = streams.Join(session, link.cancel);
  if (!seat.ok()) return seat.status();
  AckWindow& window = (*seat)->window();
  Executor writer(1);
  writer.Post([&] { WriteAcks(window, link); });
  absl::Status status;
  {
    const absl::Cleanup end = [&] { window.EndScans(); };
    status = ReadScans(pipeline, session, window, link, request);
  }
  status.Update(writer.WaitUntilIdle());
  return status;
}

}  // namespace isthmus::rpc
