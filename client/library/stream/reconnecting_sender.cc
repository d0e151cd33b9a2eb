#include "client/library/stream/reconnecting_sender.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "client/library/stream/older_server.h"

namespace isthmus::client {
namespace {

// A scan may take as long as it needs at this rate before its link counts as stalled.
constexpr double kSlowestBytesPerS = 8000;

BackoffOptions Patience(BackoffOptions backoff, bool for_ever) {
  if (for_ever) backoff.max_attempts = std::numeric_limits<int>::max();
  return backoff;
}

}  // namespace

ReconnectingSender::ReconnectingSender(SessionLink* link, ScanSource* source,
                                       const ReconnectingSenderOptions& options)
    : link_(link),
      source_(source),
      options_(options),
      clock_(link->clock()),
      longest_s_(link->options().call_timeout_s),
      first_s_(options.first_deadline_s > 0 ? std::min(options.first_deadline_s, longest_s_)
                                            : longest_s_),
      deadline_s_(first_s_),
      writer_([this] { WriteLoop(); }) {}

ReconnectingSender::~ReconnectingSender() {
  Abandon();
  writer_.join();
}

void ReconnectingSender::Abandon() {
  source_->InterruptLink();
  MutexLock lock(&mutex_);
  abandoned_ = true;
  if (call_ != nullptr) call_->Cancel();
  changed_.SignalAll();
}

void ReconnectingSender::WriteLoop() {
  Backoff backoff(Patience(options_.backoff, options_.for_ever), link_->ways());
  absl::Status status;
  for (;;) {
    const double began_s = clock_.Now();
    bool streamed = false;
    status = RunLink();
    {
      MutexLock lock(&mutex_);
      streamed = std::exchange(streamed_, false);
      if (std::exchange(progress_, false)) backoff.Reset();
      most_bytes_ = LargestMessage(status).value_or(0);
      if (abandoned_ || !WorthAnotherTry(status)) break;
    }
    const std::optional<double> delay = backoff.Next();
    if (!delay) break;
    source_->OnLinkLost();
    TellUnlessEmpty(outage_.Failed(status, clock_.Now()));
    // The time in which nobody answered counts as waiting, so that a link that comes back is
    // noticed soon. After one that stood robots do not all come back at the same instant.
    const double waited_s = streamed ? 0 : clock_.Now() - began_s;
    // A server that is full says when to come again; the delay on top spreads those who do.
    const double asked_s = AskedToWait(status).value_or(0);
    WaitBeforeRetry(asked_s + std::max(0.0, *delay - waited_s));
  }
  if (status.ok()) TellUnlessEmpty(outage_.Ended(clock_.Now()));
  source_->OnEnd(link_->Explain(status));
}

void ReconnectingSender::TellUnlessEmpty(const std::string& news) {
  if (!news.empty()) source_->Tell(news);
}

bool ReconnectingSender::WorthAnotherTry(const absl::Status& status) const {
  // ABORTED: since it acknowledged scans it was started again without them.
  if (absl::IsUnavailable(status) || absl::IsAborted(status) || AskedToWait(status)) return true;
  if (!options_.for_ever) return false;
  switch (status.code()) {
    case absl::StatusCode::kResourceExhausted:  // Its disk is full, or its threads are.
    case absl::StatusCode::kDeadlineExceeded:   // Something on the way to it gave up waiting.
    case absl::StatusCode::kInternal:  // gRPC's word for a link that was cut at a bad moment.
    case absl::StatusCode::kUnknown:
    case absl::StatusCode::kDataLoss:
    case absl::StatusCode::kOutOfRange:  // It was started again since it told where it stands.
      return true;
    default:
      return false;
  }
}

absl::Status ReconnectingSender::AskServer(ScanSource::Duration duration,
                                           const ScanSource::Attempt& attempt) {
  double deadline_s = link_->options().transfer_timeout_s;
  if (duration == ScanSource::Duration::kShort) {
    MutexLock lock(&mutex_);
    deadline_s = deadline_s_;
  }
  const std::unique_ptr<SessionCall> call = link_->NewCall(deadline_s);
  {
    MutexLock lock(&mutex_);
    if (abandoned_) return absl::CancelledError("given up");
    call_ = call.get();
  }
  const absl::Status status = attempt(*call);
  {
    MutexLock lock(&mutex_);
    call_ = nullptr;
    // A server that goes down ends what it is at.
    if (absl::IsCancelled(status) && !abandoned_) return absl::UnavailableError(status.message());
  }
  if (!absl::IsDeadlineExceeded(status)) return status;
  // A sender that does not wait for ever has waited for long.
  if (duration == ScanSource::Duration::kLong && !options_.for_ever) return status;
  // A connection that stands but is slow is given more time; one that does not even stand is begun
  // anew, which is heard of sooner than waiting for what TCP sends again.
  const bool slow = call->connected();
  call->Renew();
  MutexLock lock(&mutex_);
  deadline_s_ = slow ? std::min(2 * deadline_s_, longest_s_) : first_s_;
  return absl::UnavailableError(absl::StrCat("no answer within ", deadline_s, " s"));
}

absl::Status ReconnectingSender::RunLink() {
  const ScanSource::Ask ask = [this](ScanSource::Duration duration,
                                     const ScanSource::Attempt& attempt) {
    return AskServer(duration, attempt);
  };
  const absl::StatusOr<OpenedSession> session = source_->OpenSession(ask);
  if (!session.ok()) return session.status();
  // The session's state at the server. Also the cheapest way to see if the server is there.
  v1::Session known;
  v1::GetSessionRequest request;
  request.set_session(session->id);
  absl::Status status = AskServer(ScanSource::Duration::kShort, [&](SessionCall& call) {
    return call.GetSession(request, &known);
  });
  if (status.ok() && IsAnother(known, *session)) {
    status = absl::NotFoundError(
        absl::StrCat("session ", session->id,
                     " is another one now, opened since: the server has another map "
                     "folder, or the session was deleted"));
  }
  if (status.ok()) status = CheckSession(known);
  if (!status.ok() && !absl::IsNotFound(status)) return status;
  if (!status.ok()) known.Clear();
  const absl::StatusOr<bool> begun = source_->BeginLink(known);
  // The server's own words are better.
  if (!begun.ok()) return absl::IsNotFound(begun.status()) ? status : begun.status();
  {
    MutexLock lock(&mutex_);
    progress_ = progress_ || *begun;
  }
  known.set_id(session->id);
  status = source_->complete() ? absl::OkStatus() : StreamScans(known);
  source_->InterruptLink();
  if (absl::IsFailedPrecondition(status)) return Refused(status);
  if (status.ok()) status = source_->ConcludeSession(ask);
  return absl::IsNotFound(status) ? Refused(status) : status;
}

absl::Status ReconnectingSender::Refused(const absl::Status& status) {
  if (!options_.for_ever) return status;
  MutexLock lock(&mutex_);
  const bool again = std::exchange(was_refused_, true) && !progress_;
  return again ? status : absl::UnavailableError(status.message());
}

absl::Status ReconnectingSender::StreamScans(const v1::Session& session) {
  const std::unique_ptr<SessionCall> call = link_->NewCall(0);
  {
    MutexLock lock(&mutex_);
    if (abandoned_) return absl::CancelledError("the stream was given up");
    call_ = call.get();
    over_ = stalled_ = writing_ = false;
    streamed_ = true;
    moved_s_ = clock_.Now();
    unanswered_.clear();
  }
  const std::unique_ptr<ScanWire> wire = call->StreamScans();
  std::thread reader([&] { ReadFrom(*wire); });
  std::thread watchman([&] { WatchProgress(); });
  SendOn(*wire, session);
  reader.join();
  watchman.join();
  absl::Status status = wire->Finish();
  MutexLock lock(&mutex_);
  call_ = nullptr;
  if (stalled_) {
    status = absl::UnavailableError(
        absl::StrCat("no progress for ", options_.stall_timeout_s, " s: opened anew"));
  } else if ((status.ok() && !source_->complete()) || (absl::IsCancelled(status) && !abandoned_)) {
    // The server ended the stream of its own accord: it is going down.
    status = absl::UnavailableError("the server closed the stream");
  }
  if (absl::IsUnavailable(status)) call->Renew();
  return status;
}

ScanSource::Request ReconnectingSender::NextThatFits(const v1::Session& session) {
  ScanSource::Request request = source_->NextRequest();
  if (request == nullptr) return nullptr;
  request = ForServer(std::move(request), session.quantized_version());
  uint64_t most_bytes = 0;
  {
    MutexLock lock(&mutex_);
    most_bytes = most_bytes_;
  }
  if (most_bytes == 0 || request->ByteSizeLong() <= most_bytes) return request;
  return source_->InPlaceOf(request, most_bytes);
}

void ReconnectingSender::SendOn(ScanWire& wire, const v1::Session& session) {
  v1::StreamScansRequest hello;
  hello.set_session(session.id());
  bool open = wire.Write(hello);
  while (open) {
    const ScanSource::Request request = NextThatFits(session);
    if (request == nullptr) break;
    {
      MutexLock lock(&mutex_);
      if (unanswered_.empty()) moved_s_ = clock_.Now();
      unanswered_.push_back(request->scan().cloud().data().size());
      writing_ = true;
    }
    open = wire.Write(*request);
    MutexLock lock(&mutex_);
    writing_ = false;
    moved_s_ = clock_.Now();
  }
  wire.WritesDone();
}

void ReconnectingSender::ReadFrom(ScanWire& wire) {
  v1::StreamScansResponse response;
  while (wire.Read(&response)) {
    const bool news = source_->HandleResponse(response);
    if (news) TellUnlessEmpty(outage_.Ended(clock_.Now()));
    MutexLock lock(&mutex_);
    progress_ = progress_ || news;
    moved_s_ = clock_.Now();
    if (response.sequence() != 0 && !unanswered_.empty()) unanswered_.pop_front();
  }
  source_->InterruptLink();
  MutexLock lock(&mutex_);
  over_ = true;
  changed_.SignalAll();
}

void ReconnectingSender::WatchProgress() {
  if (options_.stall_timeout_s <= 0) return;
  MutexLock lock(&mutex_);
  while (!over_) {
    const bool busy = writing_ || !unanswered_.empty();
    const double size = unanswered_.empty() ? 0 : static_cast<double>(unanswered_.front());
    const double until = moved_s_ + options_.stall_timeout_s + size / kSlowestBytesPerS;
    const double now = clock_.Now();
    if (busy && now >= until) {
      stalled_ = true;
      if (call_ != nullptr) call_->Cancel();
      return;
    }
    clock_.WaitUntil(&changed_, &mutex_, now >= until ? now + options_.stall_timeout_s : until,
                     [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return over_; });
  }
}

void ReconnectingSender::WaitBeforeRetry(double seconds) {
  if (link_->options().sleep) return link_->Sleep(seconds);
  MutexLock lock(&mutex_);
  clock_.WaitUntil(&changed_, &mutex_, clock_.Now() + seconds,
                   [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return abandoned_; });
}

}  // namespace isthmus::client
