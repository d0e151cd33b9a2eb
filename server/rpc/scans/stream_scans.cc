#include "server/rpc/scans/stream_scans.h"

#include <absl/cleanup/cleanup.h>
#include <absl/status/statusor.h>
#include <absl/strings/str_cat.h>

#include <chrono>
#include <string>
#include <tuple>
#include <utility>

#include "api/convert/cloud.h"
#include "api/convert/session.h"
#include "server/rpc/reply.h"
#include "server/rpc/streams/messages.h"

namespace isthmus::rpc {

ScanReactor::ScanReactor(StreamHost* host, grpc::CallbackServerContext* context)
    : ScanReactorBase(host, &host->scans, context, "StreamScans"),
      look_again_(&host->watchdog, [this] { Post([this] { Pump(); }); }) {}

void ScanReactor::OnMessage(grpc::ByteBuffer message) {
  if (status_) return;  // Read before the stream began to end: not taken.
  share_ = host().budget.Ask(message.Length(), [this] { Post([this] { Pump(); }); });
  message_ = std::move(message);
  arrived_ns_ =
      std::chrono::nanoseconds(std::chrono::steady_clock::now().time_since_epoch()).count();
  Pump();
}

void ScanReactor::OnReadsDone() {
  if (registration_ == nullptr) {
    return End(absl::InvalidArgumentError("the first message of the stream must name its session"));
  }
  EndScans(absl::OkStatus());
  Pump();
}

void ScanReactor::OnStop() {
  const absl::Status stopped =
      absl::UnavailableError("the server ends this stream; open another one");
  if (registration_ == nullptr) return End(stopped);
  EndScans(stopped);
  Pump();
}

void ScanReactor::OnEnd() {
  look_again_.Disarm();
  if (registration_ != nullptr) registration_->window().Close();
  registration_.reset();
  message_.reset();
  scan_.reset();
  share_.reset();
}

void ScanReactor::EndScans(const absl::Status& status) {
  if (status_) return;
  status_ = status;
  message_.reset();
  scan_.reset();
  share_.reset();
  if (registration_ != nullptr) registration_->window().EndScans();
}

void ScanReactor::Pump() {
  if (ended()) return;
  if (registration_ != nullptr && registration_->window().closed()) {
    return End(absl::CancelledError(
        "the session was deleted, or a newer stream of it took over from this one"));
  }
  absl::Status status;
  if (message_ && share_->granted()) status = TakeMessage();
  if (status.ok() && scan_) status = SubmitScan();
  if (!status.ok()) {
    if (registration_ == nullptr) return End(status);
    EndScans(status);
  }
  WriteAck();
  if (status_) {
    if (registration_->window().drained() && !writing_) End(*status_);
  } else if (!message_ && !scan_ && registration_->window().HasRoom()) {
    ReadNext();
  }
}

absl::Status ScanReactor::TakeMessage() {
  v1::StreamScansRequest request;
  absl::Status status = ReadMessage(&*message_, &request);
  message_.reset();
  if (!status.ok()) return status;
  if (registration_ == nullptr) {
    if (status = BeginSession(request.session()); !status.ok()) return status;
  } else if (!request.session().empty() && request.session() != registration_->session().value()) {
    return absl::InvalidArgumentError(absl::StrCat(
        "the stream is of session \"", registration_->session().value(),
        "\" but a message names \"", request.session(), "\": open another stream for it"));
  }
  if (request.has_scan()) return TakeScan(std::move(*request.mutable_scan()));
  share_.reset();
  return absl::OkStatus();
}

absl::Status ScanReactor::BeginSession(const std::string& name) {
  if (name.empty()) {
    return absl::InvalidArgumentError("the first message of the stream must name its session");
  }
  const SessionId session(name);
  if (const auto own = call().FedSession(session); !own.ok()) return own.status();
  // The window may outlive this stream, in the pipeline's hands.
  const auto pump = [weak = weak_from_this()] {
    if (const auto self = weak.lock()) {
      auto* stream = static_cast<ScanReactor*>(self.get());
      stream->Post([stream] { stream->Pump(); });
    }
  };
  auto registration = call().site->streams.Register(session, pump);
  if (!registration.ok()) return registration.status();
  registration_ = *std::move(registration);
  return absl::OkStatus();
}

absl::Status ScanReactor::TakeScan(v1::ScanMessage&& message) {
  ScanUpload scan;
  scan.arrived_ns = arrived_ns_;
  scan.sequence = message.sequence();
  scan.end_stamp_ns = message.end_stamp_ns();
  if (scan.sequence == 0) {
    return absl::InvalidArgumentError("a scan has sequence 0: sequences count from 1");
  }
  auto payload = convert::FromMessage(std::move(*message.mutable_cloud()));
  // A scan that cannot even be expressed goes on as an empty cloud, so that its sequence is used up
  // and its rejection comes in order; the reason given is ours.
  reason_.clear();
  if (payload.ok()) {
    scan.payload = *std::move(payload);
  } else {
    reason_ = std::string(payload.status().message());
  }
  scan_ = std::move(scan);
  return absl::OkStatus();
}

absl::Status ScanReactor::SubmitScan() {
  AckWindow& window = registration_->window();
  const uint64_t sequence = scan_->sequence;
  // Its acknowledgement may come at once.
  window.Expect(sequence, std::move(reason_), std::move(share_));
  // Also where something is thrown: nobody would write that acknowledgement.
  absl::Cleanup withdraw = [&] { std::tie(reason_, share_) = window.Withdraw(sequence); };
  const absl::StatusOr<bool> taken =
      call().pipeline().sessions().OfferScan(registration_->session(), &*scan_);
  if (!taken.ok()) return taken.status();
  if (!*taken) {
    // The next acknowledgement wakes this stream, unless it came just now.
    look_again_.Arm(kLookAgain);
    return absl::OkStatus();
  }
  std::move(withdraw).Cancel();
  look_again_.Disarm();
  scan_.reset();
  return absl::OkStatus();
}

void ScanReactor::WriteAck() {
  if (writing_ || registration_ == nullptr) return;
  std::optional<ScanAck> ack = registration_->window().Next();
  if (!ack) return;
  ack->reason = CutText(ack->reason, kMaxReason);
  ack_ = ToBytes(convert::ToMessage(*ack));
  writing_ = true;
  StartWrite(&ack_);
}

void ScanReactor::OnWriteDone(bool ok) {
  Post([this, ok] {
    writing_ = false;
    if (!ok) return End(absl::CancelledError("the client went away"));
    Pump();
  });
}

}  // namespace isthmus::rpc
