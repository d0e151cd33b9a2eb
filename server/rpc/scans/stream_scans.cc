#include "server/rpc/scans/stream_scans.h"

#include <absl/cleanup/cleanup.h>
#include <absl/strings/str_cat.h>

#include <memory>
#include <utility>

#include "api/convert/cloud.h"
#include "api/convert/session.h"
#include "core/concurrency/executor.h"

namespace isthmus::rpc {
namespace {

absl::Status Submit(server::Pipeline& pipeline, const SessionId& session, AckWindow& window,
                    v1::ScanMessage&& message) {
  ScanUpload scan;
  scan.sequence = message.sequence();
  scan.end_stamp_ns = message.end_stamp_ns();
  if (scan.sequence == 0) {
    return absl::InvalidArgumentError("a scan has sequence 0: sequences count from 1");
  }
  auto payload = convert::FromMessage(std::move(*message.mutable_cloud()));
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
  // Also where something is thrown: nobody would write that acknowledgement.
  absl::Cleanup withdraw = [&] { window.Withdraw(sequence); };
  const absl::Status status = pipeline.SubmitScan(session, std::move(scan));
  if (status.ok()) std::move(withdraw).Cancel();
  return status;
}

// `request` holds the first message.
absl::Status ReadScans(const Call& call, const SessionId& session, AckWindow& window,
                       const ScanLink& link, v1::StreamScansRequest& request) {
  do {
    if (!request.session().empty() && request.session() != session.value()) {
      return absl::InvalidArgumentError(absl::StrCat("the stream is of session \"", session.value(),
                                                     "\" but a message names \"", request.session(),
                                                     "\": open another stream for it"));
    }
    if (request.has_scan()) {
      absl::Status status =
          Submit(call.pipeline(), session, window, std::move(*request.mutable_scan()));
      if (!status.ok()) return status;
    }
    if (absl::Status allowed = call.Allowed(); !allowed.ok()) return allowed;
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
    if (!link.write(convert::ToMessage(*ack))) break;
  }
}

}  // namespace

absl::Status StreamScans(const Call& call, const ScanLink& link) {
  v1::StreamScansRequest request;
  if (!link.read(&request) || request.session().empty()) {
    return absl::InvalidArgumentError("the first message of the stream must name its session");
  }
  const SessionId session(request.session());
  if (const auto own = call.OwnSession(session); !own.ok()) return own.status();
  auto registration = call.site->streams.Register(session, link.cancel);
  if (!registration.ok()) return registration.status();
  AckWindow& window = (*registration)->window();
  Executor writer(1);
  writer.Post([&] { WriteAcks(window, link); });
  absl::Status status;
  {
    const absl::Cleanup end = [&] { window.EndScans(); };
    status = ReadScans(call, session, window, link, request);
  }
  status.Update(writer.WaitUntilIdle());
  return status;
}

}  // namespace isthmus::rpc
