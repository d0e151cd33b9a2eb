#include "client/library/stream/memory_stream.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <utility>

#include "api/convert/cloud.h"
#include "api/convert/session.h"
#include "core/codec/quantized.h"

namespace isthmus::client {

absl::StatusOr<PointPayload> Prepare(PointPayload payload, const ScanStreamOptions& options,
                                     int newest_version) {
  if (options.resolution_m <= 0 || payload.encoding != PayloadEncoding::kRaw) return payload;
  return codec::Quantize(payload, options.resolution_m, newest_version);
}

MemoryStream::MemoryStream(std::shared_ptr<SessionLink> link, const v1::Session& session,
                           const ScanStreamOptions& options)
    : link_(std::move(link)),
      session_(session.id()),
      created_ns_(session.created_ns()),
      options_(options),
      window_(session.last_sequence() + 1, std::max<size_t>(options.window, 1),
              options.spool_bytes) {
  StartSender();
}

void MemoryStream::StartSender() {
  sender_.emplace(link_.get(), static_cast<ScanSource*>(this),
                  ReconnectingSenderOptions{.backoff = link_->options().backoff});
}

absl::Status MemoryStream::Push(int64_t end_stamp_ns, PointPayload payload) {
  absl::StatusOr<PointPayload> prepared = Prepare(std::move(payload), options_);
  if (!prepared.ok()) return prepared.status();
  const size_t bytes = prepared->data.size();
  auto request = std::make_shared<v1::StreamScansRequest>();
  request->mutable_scan()->set_end_stamp_ns(end_stamp_ns);
  *request->mutable_scan()->mutable_cloud() = convert::ToMessage(*std::move(prepared));

  MutexLock lock(&mutex_);
  while (!done_ && !finishing_ && window_.full()) changed_.Wait(&mutex_);
  if (done_ && !result_.ok()) return result_;
  if (finishing_) return absl::FailedPreconditionError("the stream was finished");
  window_.Add(std::move(request), bytes);
  stamps_.push_back(end_stamp_ns);
  ++stats_.pushed;
  changed_.SignalAll();
  return absl::OkStatus();
}

absl::Status MemoryStream::Finish() {
  MutexLock lock(&mutex_);
  return AwaitEnd();
}

absl::Status MemoryStream::AwaitEnd() {
  finishing_ = true;
  changed_.SignalAll();
  while (!done_) changed_.Wait(&mutex_);
  return result_;
}

absl::StatusOr<SessionStatus> MemoryStream::FinishSession() {
  MutexLock concluding(&concluding_);
  for (;;) {
    {
      MutexLock lock(&mutex_);
      conclude_ = true;
      if (absl::Status status = AwaitEnd(); !status.ok()) return status;
      if (finished_) return convert::FromMessage(*finished_);
      done_ = false;  // The sender ended before it was to conclude.
    }
    StartSender();
  }
}

absl::Status MemoryStream::ConcludeSession(const Ask& ask) {
  uint64_t last_sequence = 0;
  {
    MutexLock lock(&mutex_);
    if (!conclude_) return absl::OkStatus();
    last_sequence = window_.acked_sequence();
  }
  v1::Session session;
  absl::Status status = AskToFinish(ask, session_.value(), last_sequence, &session);
  if (!status.ok()) return status;
  MutexLock lock(&mutex_);
  stats_.durable_sequence = std::max(stats_.durable_sequence, session.durable_sequence());
  finished_ = std::move(session);
  return absl::OkStatus();
}

void MemoryStream::GiveUp() {
  MutexLock lock(&mutex_);
  if (done_) return;
  result_ = absl::CancelledError("the stream was given up");
  done_ = true;
  changed_.SignalAll();
}

ScanStreamStats MemoryStream::stats() const {
  MutexLock lock(&mutex_);
  return stats_;
}

absl::Status MemoryStream::BeginLink(const v1::Session& known) {
  if (known.id().empty()) return absl::NotFoundError("no such session");
  MutexLock lock(&mutex_);
  const bool is_over = stats_.pushed > 0 && window_.all_acked();
  if (known.state() == v1::Session::FINISHED && !is_over) {
    return absl::FailedPreconditionError(absl::StrCat(
        "session ", known.id(), " is finished: create a new session for robot ", known.robot()));
  }
  if (known.last_sequence() > window_.sent().value_or(known.last_sequence())) {
    return absl::FailedPreconditionError(
        absl::StrCat("session ", known.id(), " has ", known.last_sequence(),
                     " scans, and only those up to ", *window_.sent(),
                     " were sent from here: another program streams into it; open a session "
                     "of your own"));
  }
  // Scans of an earlier program may just have been taken up.
  if (!window_.sent()) window_.Renumber(known.last_sequence());
  window_.Rewind(known.last_sequence());
  interrupted_ = false;
  return absl::OkStatus();
}

ScanSource::Request MemoryStream::NextRequest() {
  MutexLock lock(&mutex_);
  for (;;) {
    if (interrupted_) return nullptr;
    if (const auto [request, sequence] = window_.TakeUnsent(); request != nullptr) {
      request->mutable_scan()->set_sequence(sequence);
      stats_.sent_bytes += request->scan().cloud().data().size();
      return request;
    }
    // Half-closing early is fine: the server acknowledges what is queued before it ends.
    if (finishing_) return nullptr;
    changed_.Wait(&mutex_);
  }
}

void MemoryStream::InterruptLink() {
  MutexLock lock(&mutex_);
  interrupted_ = true;
  changed_.SignalAll();
}

bool MemoryStream::HandleResponse(const v1::StreamScansResponse& response) {
  ScanAck ack = convert::FromMessage(response);
  ack.session = session_;
  {
    MutexLock lock(&mutex_);
    const uint64_t before = window_.at_server();
    const bool news = ack.sequence != 0 && window_.Ack(ack.sequence);
    window_.Durable(ack.durable_sequence);
    stats_.durable_sequence = std::max(stats_.durable_sequence, ack.durable_sequence);
    if (!news) return window_.at_server() > before;
    ack.end_stamp_ns = stamps_.front();
    stamps_.pop_front();
    stats_.processed += ack.outcome == ScanOutcome::kProcessed;
    stats_.duplicates += ack.outcome == ScanOutcome::kDuplicate;
    stats_.rejected += ack.outcome == ScanOutcome::kRejected;
    stats_.skipped += ack.outcome == ScanOutcome::kSkipped;
    changed_.SignalAll();
  }
  if (options_.on_ack) options_.on_ack(ack);
  return true;
}

bool MemoryStream::complete() const {
  MutexLock lock(&mutex_);
  return finishing_ && window_.settled();
}

void MemoryStream::OnLinkLost() {
  MutexLock lock(&mutex_);
  ++stats_.reconnects;
}

void MemoryStream::Tell(const std::string& news) {
  if (options_.on_event) options_.on_event(news);
}

void MemoryStream::OnEnd(const absl::Status& status) {
  MutexLock lock(&mutex_);
  if (!done_) result_ = status;  // Else it was given up.
  done_ = true;
  changed_.SignalAll();
}

}  // namespace isthmus::client
