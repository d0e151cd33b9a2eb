#include "client/library/stream/session_sender.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <utility>

#include "api/convert/session.h"
#include "client/library/spool/set_aside.h"

namespace isthmus::client {
namespace {

constexpr char kLostReason[] = "damaged in the spool, or dropped from it";
constexpr char kAsideReason[] =
    "larger than a message that the server takes (network.max_receive_bytes)";
// Scans that are set aside are told of one by one up to so many; the statistics count all.
constexpr uint64_t kToldScans = 3;

ReconnectingSenderOptions ToSenderOptions(const ScanStreamOptions& options,
                                          const BackoffOptions& patience) {
  if (options.spool_dir.empty()) return {.backoff = patience};
  ReconnectingSenderOptions sender;
  sender.for_ever = true;
  sender.backoff.first_delay_s = options.spool.retry_first_s;
  sender.backoff.max_delay_s = options.spool.retry_max_s;
  sender.first_deadline_s = options.spool.attempt_timeout_s;
  sender.stall_timeout_s = options.spool.stall_timeout_s;
  return sender;
}

}  // namespace

SessionSender::SessionSender(SessionLink* link, std::unique_ptr<SessionSpool> spool,
                             const ScanStreamOptions& options, Host host)
    : link_(link),
      spool_(std::move(spool)),
      options_(options),
      host_(std::move(host)),
      clock_(link->clock()),
      mine_from_(spool_->written() + 1),
      acked_(spool_->first() - 1),
      bucket_(options.spool.backfill_bytes_per_s) {
  const SpoolIdentity identity = spool_->identity();
  opened_.robot = identity.request.robot();
  opened_.sensor = identity.request.sensor();
  opened_.session = SessionId(identity.session);
  opened_.last_sequence = spool_->written() - std::min(spool_->written(), identity.base);
  opened_.last_stamp_ns = spool_->StampBefore(mine_from_);
  is_unsure_ = on_disk() && !identity.session.empty();
  if (identity.unsure_from != 0) mine_from_ = std::min(mine_from_, identity.unsure_from);
}

SessionSender::~SessionSender() = default;

void SessionSender::Start() {
  TellNotes();
  sender_.reset();  // It may have ended before.
  ScanSource* const source = this;
  sender_ = std::make_unique<ReconnectingSender>(
      link_, source, ToSenderOptions(options_, link_->options().backoff));
}

absl::Status SessionSender::Push(int64_t end_stamp_ns, std::string scan) {
  {
    MutexLock lock(&mutex_);
    if (is_unsure_) {
      if (absl::Status status = MarkUnsure(mine_from_); !status.ok()) return status;
      is_unsure_ = false;
    }
  }
  const auto sequence = spool_->Append(end_stamp_ns, std::move(scan), clock_.Now());
  if (!sequence.ok()) return sequence.status();
  MutexLock lock(&mutex_);
  stats_.pushed += *sequence > known_up_to_;
  changed_.SignalAll();
  return absl::OkStatus();
}

void SessionSender::Close(bool conclude) {
  bool again = false;
  {
    MutexLock lock(&mutex_);
    closed_ = true;
    conclude_ = conclude_ || conclude;
    again = conclude_ && !finished_ && ended_ && ended_->ok();
    if (again) ended_.reset();
    changed_.SignalAll();
  }
  if (again) Start();
}

SessionId SessionSender::session() const { return SessionId(spool_->identity().session); }

ScanStreamStats SessionSender::stats() const {
  MutexLock lock(&mutex_);
  ScanStreamStats stats = stats_;
  stats.backlog = spool_->written() - std::min(spool_->written(), acked_);
  stats.spool_bytes = spool_->bytes();
  return stats;
}

uint64_t SessionSender::backlog() const { return stats().backlog; }

bool SessionSender::behind() const {
  MutexLock lock(&mutex_);
  return !closed_ && TooFarBehind();
}

std::optional<absl::Status> SessionSender::ended() const {
  MutexLock lock(&mutex_);
  return ended_;
}

std::optional<v1::Session> SessionSender::finished() const {
  MutexLock lock(&mutex_);
  return finished_;
}

absl::StatusOr<OpenedSession> SessionSender::OpenSession(const Ask& ask) {
  SpoolIdentity identity = spool_->identity();
  if (!identity.session.empty()) return OpenedSession{identity.session, identity.created_ns};
  v1::Session session;
  // May be repeated: its request_id, which the spool keeps, makes it one session.
  absl::Status status = ask(Duration::kShort, [&](SessionCall& call) {
    return call.CreateSession(identity.request, &session);
  });
  if (!status.ok()) return status;
  identity.session = session.id();
  identity.created_ns = session.created_ns();
  if (status = spool_->SetIdentity(identity); !status.ok()) return status;
  host_.event(absl::StrCat("session ", session.id(), " of robot ", session.robot()));
  return OpenedSession{identity.session, identity.created_ns};
}

absl::Status SessionSender::MarkUnsure(uint64_t from) {
  SpoolIdentity identity = spool_->identity();
  if (std::exchange(identity.unsure_from, from) == from) return absl::OkStatus();
  return spool_->SetIdentity(identity);
}

absl::Status SessionSender::Expect(const v1::Session& known) {
  MutexLock lock(&mutex_);
  if (absl::Status status = CheckKnown(known); !status.ok()) return status;
  const uint64_t last = known.last_sequence() + spool_->identity().base;
  if (is_replayed() && last >= mine_from_) {
    opened_.last_sequence = spool_->written();
    opened_.server_ahead = static_cast<int64_t>(last) - static_cast<int64_t>(spool_->written());
    opened_.server_sequence = known.last_sequence();
    known_up_to_ = last;
    mine_from_ = last + 1;
  } else if (absl::Status follows = FollowServer(last); !follows.ok()) {
    return absl::IsAborted(follows) ? Gone(std::string(follows.message())) : follows;
  } else if (last > opened_.last_sequence + spool_->identity().base) {
    opened_.last_sequence = known.last_sequence();
  }
  is_unsure_ = false;
  return absl::OkStatus();
}

absl::Status SessionSender::Gone(const std::string& why) const {
  const SpoolIdentity identity = spool_->identity();
  const std::string advice =
      on_disk() ? ". The scans are kept in the spool: have those that are left sent into a new "
                  "session (push --new-session, if_session_is_gone), or remove the folder if "
                  "they are not needed, or the whole drive is to be pushed again"
                : ": create a new session for robot " + identity.request.robot();
  return absl::FailedPreconditionError(
      absl::StrCat("session ", identity.session, " cannot go on: ", why, advice));
}

absl::Status SessionSender::FinishedBeyond(uint64_t last, uint64_t newest) const {
  const SpoolIdentity identity = spool_->identity();
  return absl::FailedPreconditionError(absl::StrCat(
      "session ", identity.session, " cannot go on: it was finished with ", last - identity.base,
      " scans, and only those up to ", newest - std::min(newest, identity.base),
      " are from here: another program streamed into it, or the spool was damaged. Nothing is sent "
      "elsewhere, as it cannot be told which scans of the spool are in it. Have a recording pushed "
      "with another folder, into a session of its own; remove ",
      options_.spool_dir, " once its scans are not needed"));
}

bool SessionSender::CanTell(const v1::Session& known) const {
  if (known.state() != v1::Session::FINISHED || !on_disk()) return true;
  const SpoolIdentity identity = spool_->identity();
  // Scans that were taken out of the server's reach were never sent.
  const bool has_own = identity.unsure_from != 0 && sent_ == 0 && !is_replayed();
  return has_own || known.last_sequence() + identity.base <= newest_known();
}

bool SessionSender::MayMoveOn(const v1::Session& known) const {
  MutexLock lock(&mutex_);
  return CanTell(known);
}

absl::Status SessionSender::Again(const std::string& why) const {
  return absl::FailedPreconditionError(
      absl::StrCat("session ", spool_->identity().session, " cannot go on: ", why,
                   ". Try again while the server can be reached: its scans are then compared with "
                   "the recording"));
}

absl::Status SessionSender::CheckKnown(const v1::Session& known) const {
  if (known.id().empty() && !on_disk()) return absl::NotFoundError("no such session");
  if (known.id().empty()) {
    return Gone(
        "the server does not know it; it was deleted, or the server has another map folder");
  }
  const SpoolIdentity identity = spool_->identity();
  const uint64_t last = known.last_sequence() + identity.base;
  if (known.state() == v1::Session::FINISHED) {
    const bool has_all = last >= spool_->written() && (last <= newest_known() || !on_disk());
    if (closed_ && (concluding_ || has_all)) return absl::OkStatus();
    return CanTell(known) ? Gone("it was finished") : FinishedBeyond(last, newest_known());
  }
  const bool may_skip =
      options_.spool.when_full == WhenFull::kDropOldest || (!on_disk() && sent_ < mine_from_);
  if (last + 1 >= spool_->first() || may_skip) return absl::OkStatus();
  return Gone(absl::StrCat("the server has its scans up to ", known.last_sequence(),
                           ", and those from ", spool_->first() - identity.base, " are kept here; ",
                           on_disk() ? "the server was restored from an older backup"
                                     : "a server that crashes asks for more of them "
                                       "(ScanStreamOptions::spool_bytes)"));
}

absl::Status SessionSender::FollowServer(uint64_t last) {
  const uint64_t from = mine_from_ - 1, newest = newest_known();
  const bool is_behind = !on_disk() && newest == from && last < from;
  if (last <= newest && !is_behind) return absl::OkStatus();
  if (opened_.server_ahead && !taken_up_) {  // Late scans of an earlier program.
    mine_from_ = last + 1;
    return absl::OkStatus();
  }
  const bool may_skip = newest == from && !is_replayed();
  const absl::Status skipped =
      may_skip ? spool_->Skip(from, last) : absl::AbortedError("they were sent");
  if (absl::IsAborted(skipped)) {
    const uint64_t base = spool_->identity().base;
    return absl::AbortedError(absl::StrCat("the server has its scans up to ", last - base,
                                           ", and only those up to ", newest - base,
                                           " are from here: another program streams into it",
                                           on_disk() ? ", or the spool was damaged" : ""));
  }
  if (!skipped.ok()) return skipped;
  mine_from_ = last + 1;
  acked_ = last;
  return absl::OkStatus();
}

absl::Status SessionSender::ChangeSession(const v1::Session& known, const absl::Status& why) {
  SpoolIdentity identity = spool_->identity();
  const uint64_t last = known.last_sequence() + identity.base;
  uint64_t from = spool_->first();
  if (!known.id().empty() && last > newest_known()) {
    from = std::max(from, mine_from_);  // Earlier scans were at the server.
  } else if (known.state() == v1::Session::FINISHED) {
    from = std::max(from, last + 1);
  }
  identity.base = from - 1;
  identity.session.clear();
  identity.created_ns = 0;
  identity.unsure_from = 0;
  identity.request.set_request_id(absl::StrCat(identity.name(), ".", NewRequestId().substr(16)));
  if (absl::Status status = spool_->SetIdentity(identity); !status.ok()) return status;
  mine_from_ = to_send_ = from;
  sent_ = acked_ = at_server_ = from - 1;
  taken_up_ = is_unsure_ = false;
  return absl::UnavailableError(
      absl::StrCat("a new session follows: ", std::string(why.message())));
}

absl::StatusOr<bool> SessionSender::BeginLink(const v1::Session& known) {
  std::vector<ScanAck> acks;
  {
    MutexLock lock(&mutex_);
    absl::Status gone = CheckKnown(known);
    if (gone.ok()) {
      const absl::Status follows = FollowServer(known.last_sequence() + spool_->identity().base);
      if (!follows.ok() && !absl::IsAborted(follows)) return follows;
      if (!follows.ok()) {
        gone = Gone(std::string(follows.message()));
        if (absl::Status status = MarkUnsure(mine_from_); !status.ok()) return status;
        // The next program can tell, as it will compare them first.
        if (is_replayed()) return Again(std::string(follows.message()));
      }
    }
    if (!gone.ok()) {
      const bool change = options_.spool.if_session_is_gone == IfSessionIsGone::kNewSession;
      return change && CanTell(known) ? ChangeSession(known, gone) : gone;
    }
    is_unsure_ = false;
    if (absl::Status status = MarkUnsure(0); !status.ok()) return status;
    // A spool of an older program learns it now.
    if (SpoolIdentity identity = spool_->identity(); identity.created_ns != known.created_ns()) {
      identity.created_ns = known.created_ns();
      if (absl::Status status = spool_->SetIdentity(identity); !status.ok()) return status;
    }
    acks = TakeUp(known);
    interrupted_ = false;
  }
  for (const ScanAck& ack : acks) host_.acked(ack);
  host_.changed();
  if (behind()) host_.behind(this);
  return !acks.empty();
}

std::vector<ScanAck> SessionSender::TakeUp(const v1::Session& known) {
  const SpoolIdentity identity = spool_->identity();
  const uint64_t last = known.last_sequence() + identity.base;
  if (!std::exchange(taken_up_, true)) acked_ = last;
  // Scans that took effect while their acknowledgements were lost need not travel again.
  std::vector<ScanAck> acks;
  while (acked_ < last) {
    ScanAck ack;
    ack.session = SessionId(identity.session);
    ack.sequence = ++acked_ - identity.base;
    ack.end_stamp_ns = spool_->StampBefore(acked_ + 1);
    ack.outcome = ScanOutcome::kDuplicate;
    ack.durable_sequence = known.durable_sequence();
    acks.push_back(std::move(ack));
  }
  stats_.duplicates += acks.size();
  stats_.durable_sequence = std::max(stats_.durable_sequence, known.durable_sequence());
  at_server_ = last;
  over_ = known.state() == v1::Session::FINISHED;
  to_send_ = last + 1;
  spool_->Release(known.durable_sequence() + identity.base, acked_);
  return acks;
}

bool SessionSender::TooFarBehind() const {
  if (options_.spool.prefer_live_after_s <= 0 || to_send_ > spool_->written()) return false;
  const int64_t newest = spool_->StampBefore(spool_->written() + 1);
  const int64_t oldest = spool_->StampBefore(to_send_ + 1);
  return static_cast<double>(newest - oldest) > options_.spool.prefer_live_after_s * 1e9;
}

ScanSource::Request SessionSender::NextRequest() {
  std::optional<uint64_t> sequence;
  {
    MutexLock lock(&mutex_);
    sequence = AwaitNext();
    if (!sequence) return nullptr;
  }
  if (*sequence > spool_->safe()) {
    // Scans that the server has must be on the disk, or their numbers might be given again.
    if (absl::Status status = spool_->Sync(clock_.Now()); !status.ok()) {
      host_.event("the spool cannot be written: " + std::string(status.message()));
      return nullptr;
    }
  }
  Request request = MakeRequest(*sequence);
  MutexLock lock(&mutex_);
  if (interrupted_) return nullptr;
  to_send_ = *sequence + 1;
  sent_ = std::max(sent_, *sequence);
  stats_.sent_bytes += request->scan().cloud().data().size();
  return request;
}

std::optional<uint64_t> SessionSender::AwaitNext() {
  const size_t window = std::max<size_t>(options_.window, 1);
  for (;;) {
    if (interrupted_) return std::nullopt;
    const bool more = to_send_ <= spool_->written();
    // Half-closing early is fine: the server acknowledges what is queued before it ends.
    if (!more && closed_) return std::nullopt;
    if (!more || to_send_ > at_server_ + window) {
      changed_.Wait(&mutex_);
      continue;
    }
    const std::optional<SessionSpool::Entry> entry = spool_->Find(to_send_);
    const double now = clock_.Now();
    if (!entry || now - entry->appended_s <= options_.spool.live_s) return to_send_;
    const double when = bucket_.TakeTokens(static_cast<double>(entry->bytes), now);
    if (when <= now) return to_send_;
    clock_.WaitUntil(&changed_, &mutex_, when,
                     [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return interrupted_; });
  }
}

ScanSource::Request SessionSender::MakeRequest(uint64_t sequence) {
  auto request = std::make_shared<v1::StreamScansRequest>();
  v1::ScanMessage& scan = *request->mutable_scan();
  const absl::StatusOr<std::string> bytes = spool_->Read(sequence);
  if (!bytes.ok() || !scan.ParseFromString(*bytes)) {
    bool news = false;
    {
      MutexLock lock(&mutex_);
      news = sequence > lost_told_;
      lost_told_ = std::max(lost_told_, sequence);
      stats_.lost += news;
      lost_.insert(sequence);
    }
    if (news) host_.event("a scan is lost: " + std::string(bytes.status().message()));
    return EmptyRequest(sequence, spool_->StampBefore(sequence) + 1);
  }
  scan.set_sequence(sequence - spool_->identity().base);
  return request;
}

ScanSource::Request SessionSender::EmptyRequest(uint64_t sequence, int64_t stamp_ns) const {
  auto request = std::make_shared<v1::StreamScansRequest>();
  request->mutable_scan()->set_end_stamp_ns(stamp_ns);
  request->mutable_scan()->set_sequence(sequence - spool_->identity().base);
  return request;
}

ScanSource::Request SessionSender::InPlaceOf(const Request& too_large, uint64_t most_bytes) {
  if (!on_disk()) return nullptr;
  const int64_t stamp_ns = too_large->scan().end_stamp_ns();
  const uint64_t sequence = too_large->scan().sequence() + spool_->identity().base;
  const absl::StatusOr<std::string> kept = spool_->Read(sequence);
  if (!kept.ok()) return EmptyRequest(sequence, stamp_ns);  // Dropped since, and told of.
  const absl::StatusOr<std::string> path = SetAside(options_.spool_dir, stamp_ns, *kept);
  const bool is_full = absl::IsResourceExhausted(path.status());
  if (!path.ok() && !is_full) {
    host_.event("a scan cannot be set aside: " + std::string(path.status().message()));
    return nullptr;
  }
  bool is_told = true;
  {
    MutexLock lock(&mutex_);
    const bool news = sequence > aside_told_;
    aside_told_ = std::max(aside_told_, sequence);
    aside_.insert(sequence);
    stats_.set_aside += news && path.ok();
    stats_.lost += news && !path.ok();
    is_told = !news || stats_.set_aside + stats_.lost > kToldScans;
  }
  if (!is_told) {
    host_.event(absl::StrCat(
        "a scan of ", too_large->ByteSizeLong(), " bytes is larger than the ", most_bytes,
        " that the server takes (network.max_receive_bytes): ",
        path.ok() ? absl::StrCat("set aside in ", *path)
                  : absl::StrCat("it is lost, as ", std::string(path.status().message()))));
  }
  return EmptyRequest(sequence, stamp_ns);
}

void SessionSender::InterruptLink() {
  MutexLock lock(&mutex_);
  interrupted_ = true;
  changed_.SignalAll();
}

bool SessionSender::HandleResponse(const v1::StreamScansResponse& response) {
  ScanAck ack = convert::FromMessage(response);
  const SpoolIdentity identity = spool_->identity();
  ack.session = SessionId(identity.session);
  const uint64_t sequence = ack.sequence + identity.base;
  bool news = false, brought_on = false;
  uint64_t acked = 0;
  {
    MutexLock lock(&mutex_);
    stats_.durable_sequence = std::max(stats_.durable_sequence, ack.durable_sequence);
    const bool was_sent = ack.sequence != 0 && ack.sequence <= sequence && sequence <= sent_;
    brought_on = was_sent && sequence > at_server_;
    if (brought_on) at_server_ = sequence;
    news = was_sent && sequence == acked_ + 1;
    if (news) {
      acked_ = sequence;
      ack.end_stamp_ns = spool_->StampBefore(sequence + 1);
      stats_.processed += ack.outcome == ScanOutcome::kProcessed;
      stats_.duplicates += ack.outcome == ScanOutcome::kDuplicate;
      stats_.rejected += ack.outcome == ScanOutcome::kRejected;
      // The server's reason is that of the empty scan that was sent in its place.
      if (aside_.erase(sequence) > 0) ack.reason = kAsideReason;
      if (lost_.erase(sequence) > 0) ack.reason = kLostReason;
      stats_.skipped += ack.outcome == ScanOutcome::kSkipped;
    }
    acked = acked_;
    changed_.SignalAll();
  }
  spool_->Release(ack.durable_sequence + identity.base, acked);
  if (news) host_.acked(ack);
  host_.changed();
  return brought_on;
}

bool SessionSender::complete() const {
  MutexLock lock(&mutex_);
  if (!closed_ || !taken_up_) return false;
  return over_ || std::min(acked_, at_server_) >= spool_->written();
}

absl::Status SessionSender::ConcludeSession(const Ask& ask) {
  {
    MutexLock lock(&mutex_);
    if (is_replayed() && !over_ && at_server_ > spool_->written()) {
      return Gone(absl::StrCat("the server has ", at_server_ - spool_->written(),
                               " scans more than came here"));
    }
    if (!conclude_) return absl::OkStatus();
    concluding_ = true;
  }
  const SpoolIdentity identity = spool_->identity();
  v1::Session session;
  absl::Status status =
      AskToFinish(ask, identity.session, spool_->written() - identity.base, &session);
  if (!status.ok()) return status;
  MutexLock lock(&mutex_);
  finished_ = session;
  stats_.durable_sequence = session.durable_sequence();
  return spool_->Remove();
}

void SessionSender::OnLinkLost() {
  MutexLock lock(&mutex_);
  ++stats_.reconnects;
}

void SessionSender::Tell(const std::string& news) { host_.event(news); }

void SessionSender::OnEnd(const absl::Status& status) {
  {
    MutexLock lock(&mutex_);
    ended_ = status;
    changed_.SignalAll();
  }
  host_.changed();
}

void SessionSender::TellNotes() {
  for (const std::string& note : spool_->TakeNotes()) host_.event(note);
}

}  // namespace isthmus::client
