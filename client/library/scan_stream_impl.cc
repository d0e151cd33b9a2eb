#include "client/library/scan_stream_impl.h"

#include <chrono>
#include <utility>

#include "client/library/convert.h"
#include "core/codec/quantized.h"

namespace isthmus::client {

ScanStream::Impl::Impl(std::shared_ptr<Client::Link> link, SessionId session,
                       uint64_t last_sequence, const ScanStreamOptions& options)
    : link_(std::move(link)),
      session_(std::move(session)),
      options_(options),
      window_(last_sequence + 1, std::max<size_t>(options.window, 1), options.spool_bytes),
      writer_([this] { WriteLoop(); }) {}

ScanStream::Impl::~Impl() {
  {
    std::lock_guard lock(mutex_);
    abandoned_ = true;
    if (context_ != nullptr) context_->TryCancel();
    changed_.notify_all();
  }
  writer_.join();
}

absl::Status ScanStream::Impl::Push(int64_t end_stamp_ns, PointPayload payload) {
  if (options_.resolution_m > 0 && payload.encoding == PayloadEncoding::kRaw) {
    absl::StatusOr<PointPayload> compressed = codec::Quantize(payload, options_.resolution_m);
    if (!compressed.ok()) return compressed.status();
    payload = std::move(*compressed);
  }
  const size_t bytes = payload.data.size();
  auto request = std::make_shared<v1::StreamScansRequest>();
  request->mutable_scan()->set_end_stamp_ns(end_stamp_ns);
  *request->mutable_scan()->mutable_cloud() = ToProto(std::move(payload));

  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return done_ || finishing_ || !window_.full(); });
  if (done_ && !result_.ok()) return result_;
  if (finishing_) return absl::FailedPreconditionError("the stream was finished");
  request->mutable_scan()->set_sequence(window_.next_sequence());
  window_.Add(std::move(request), bytes);
  stamps_.push_back(end_stamp_ns);
  ++stats_.pushed;
  changed_.notify_all();
  return absl::OkStatus();
}

absl::Status ScanStream::Impl::Finish() {
  std::unique_lock lock(mutex_);
  finishing_ = true;
  changed_.notify_all();
  changed_.wait(lock, [&] { return done_; });
  return result_;
}

ScanStreamStats ScanStream::Impl::stats() const {
  std::lock_guard lock(mutex_);
  return stats_;
}

void ScanStream::Impl::WriteLoop() {
  Backoff backoff = link_->NewBackoff();
  absl::Status status;
  for (;;) {
    status = RunLink();
    std::unique_lock lock(mutex_);
    if (std::exchange(progress_, false)) backoff.Reset();
    if (!absl::IsUnavailable(status) || abandoned_) break;
    lock.unlock();
    const std::optional<double> delay = backoff.Next();
    if (!delay) break;
    WaitBeforeRetry(*delay);
    lock.lock();
    ++stats_.reconnects;
  }
  std::lock_guard lock(mutex_);
  result_ = link_->Explain(status);
  done_ = true;
  changed_.notify_all();
}

absl::Status ScanStream::Impl::RunLink() {
  const std::shared_ptr<Client::Link::Stubs> stubs = link_->Get();
  // Where the server stands. Also the cheapest way to see whether it is there.
  v1::Session known;
  absl::Status status = link_->Once(link_->options().call_timeout_s,
                                    [&](Client::Link::Stubs& s, grpc::ClientContext& context) {
                                      v1::GetSessionRequest request;
                                      request.set_session(session_.value());
                                      return s.sessions->GetSession(&context, request, &known);
                                    });
  if (absl::IsDeadlineExceeded(status)) return absl::UnavailableError(status.message());
  if (!status.ok()) return status;

  grpc::ClientContext context;
  {
    std::lock_guard lock(mutex_);
    if (abandoned_) return absl::CancelledError("the stream was given up");
    window_.Rewind(known.last_sequence());
    link_broken_ = false;
    context_ = &context;
  }
  auto wire = stubs->sessions->StreamScans(&context);
  std::thread reader([&] { ReadFrom(*wire); });
  SendOn(*wire);
  reader.join();
  status = ToStatus(wire->Finish());
  std::lock_guard lock(mutex_);
  context_ = nullptr;
  if (absl::IsUnavailable(status)) link_->Renew(stubs);
  const bool complete = finishing_ && window_.all_acked();
  if ((status.ok() && !complete) || (absl::IsCancelled(status) && !abandoned_)) {
    // The server ended the stream of its own accord: it is going down.
    status = absl::UnavailableError("the server closed the stream");
  }
  return status;
}

void ScanStream::Impl::SendOn(Wire& wire) {
  v1::StreamScansRequest hello;
  hello.set_session(session_.value());
  bool open = wire.Write(hello);
  while (open) {
    const std::shared_ptr<const v1::StreamScansRequest> request = NextToSend();
    if (request == nullptr) break;
    open = wire.Write(*request);
  }
  wire.WritesDone();
}

std::shared_ptr<const v1::StreamScansRequest> ScanStream::Impl::NextToSend() {
  std::unique_lock lock(mutex_);
  for (;;) {
    if (link_broken_ || abandoned_) return nullptr;
    if (auto request = window_.TakeUnsent()) {
      stats_.sent_bytes += request->scan().cloud().data().size();
      return request;
    }
    // Half-closing early is fine: the server acknowledges what is queued before it ends.
    if (finishing_) return nullptr;
    changed_.wait(lock);
  }
}

void ScanStream::Impl::ReadFrom(Wire& wire) {
  v1::StreamScansResponse response;
  while (wire.Read(&response)) TakeAck(response);
  std::lock_guard lock(mutex_);
  link_broken_ = true;
  changed_.notify_all();
}

void ScanStream::Impl::TakeAck(const v1::StreamScansResponse& response) {
  ScanAck ack = FromProto(response);
  {
    std::lock_guard lock(mutex_);
    const bool news = ack.sequence != 0 && window_.Ack(ack.sequence);
    window_.Durable(ack.durable_sequence);
    stats_.durable_sequence = std::max(stats_.durable_sequence, ack.durable_sequence);
    if (!news) return;
    progress_ = true;
    ack.end_stamp_ns = stamps_.front();
    stamps_.pop_front();
    stats_.processed += ack.outcome == ScanOutcome::kProcessed;
    stats_.duplicates += ack.outcome == ScanOutcome::kDuplicate;
    stats_.rejected += ack.outcome == ScanOutcome::kRejected;
    changed_.notify_all();
  }
  if (options_.on_ack) options_.on_ack(ack);
}

void ScanStream::Impl::WaitBeforeRetry(double seconds) {
  if (link_->options().sleep) return link_->Sleep(seconds);
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, std::chrono::duration<double>(seconds), [&] { return abandoned_; });
}

}  // namespace isthmus::client
