#include "client/library/stream/scan_stream_impl.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "api/convert/cloud.h"
#include "api/convert/session.h"
#include "client/library/spool/memory_spool.h"
#include "core/codec/quantized.h"
#include "core/io/of_file.h"

namespace isthmus::client {
namespace {

constexpr uint64_t kLargestSegment = 64u << 20;
constexpr uint64_t kSegments = 16;  // At least so many fit into a spool.
// A spool that is full of scans that the server has, but does not make durable, is too small.
constexpr double kHopeless_s = 60;
// Others may make room on the disk, of which nobody tells.
constexpr double kLookAtDiskEvery_s = 1;

void AddUp(const ScanStreamStats& part, ScanStreamStats& sum) {
  sum.pushed += part.pushed;
  sum.processed += part.processed;
  sum.duplicates += part.duplicates;
  sum.rejected += part.rejected;
  sum.skipped += part.skipped;
  sum.sent_bytes += part.sent_bytes;
  sum.reconnects += part.reconnects;
  sum.backlog += part.backlog;
  sum.spool_bytes += part.spool_bytes;
  sum.lost += part.lost;
  sum.set_aside += part.set_aside;
  sum.durable_sequence = part.durable_sequence;  // The last session's.
}

SpoolIdentity IdentityOf(const v1::CreateSessionRequest& request) {
  SpoolIdentity identity;
  identity.request = request;
  identity.request.set_request_id(NewRequestId());
  return identity;
}

SpoolIdentity IdentityOf(const v1::Session& session) {
  SpoolIdentity identity = IdentityOf(convert::ToMessage(convert::FromMessage(session).record));
  identity.session = session.id();
  identity.created_ns = session.created_ns();
  return identity;
}

}  // namespace

absl::StatusOr<PointPayload> Prepare(PointPayload payload, const ScanStreamOptions& options,
                                     int newest_version) {
  if (options.resolution_m <= 0 || payload.encoding != PayloadEncoding::kRaw) return payload;
  return codec::Quantize(payload, options.resolution_m, newest_version);
}

ScanStream::Impl::~Impl() {
  GiveUp();
  // A sender that is about to open another waits for this, and then finds that it need not.
  std::vector<std::unique_ptr<SessionSender>> senders;
  MutexLock pushing(&push_mutex_);
  {
    MutexLock lock(&mutex_);
    senders.swap(senders_);
  }
}

void ScanStream::Impl::GiveUp() {
  MutexLock lock(&mutex_);
  stopping_ = true;
  changed_.SignalAll();
}

absl::StatusOr<std::unique_ptr<ScanStream>> ScanStream::Impl::Open(
    std::shared_ptr<SessionLink> link, const ScanStreamOptions& options,
    const SpoolTarget& target) {
  std::unique_ptr<Impl> stream(new Impl(std::move(link), options));
  stream->disk_ = target.disk;
  const bool in_memory = options.spool_dir.empty();
  absl::Status status = in_memory ? stream->OpenMemory(target) : stream->OpenFolder(target);
  if (!status.ok()) return status;
  return std::make_unique<ScanStream>(std::move(stream));
}

absl::Status ScanStream::Impl::OpenMemory(const SpoolTarget& target) {
  if (!target.session) {
    return absl::InvalidArgumentError("name the spool's folder in ScanStreamOptions::spool_dir");
  }
  const v1::Session& session = *target.session;
  if (session.state() == v1::Session::FINISHED) {
    return absl::FailedPreconditionError(
        absl::StrCat("session ", session.id(), " is finished: create a new session for robot ",
                     session.robot()));
  }
  options_.spool = {};
  MutexLock pushing(&push_mutex_);
  AdoptSpool(std::make_unique<MemorySpool>(IdentityOf(session), session.last_sequence(),
                                           options_.spool_bytes));
  Newest()->Start();
  return absl::OkStatus();
}

absl::Status ScanStream::Impl::OpenFolder(const SpoolTarget& target) {
  auto folder = SpoolFolder::Open(options_.spool_dir);
  if (!folder.ok()) return io::OfFile(folder.status());
  folder_ = *std::move(folder);
  MutexLock pushing(&push_mutex_);
  auto spools = folder_->Load(SpoolOptionsFor());
  if (!spools.ok()) return io::OfFile(spools.status());
  for (auto& spool : *spools) AdoptSpool(std::move(spool));
  if (absl::Status status = CheckNewest(target); !status.ok()) return status;
  // One that was closed had a successor, which was removed or never came to be.
  SessionSender* const newest = Newest();
  if (newest == nullptr || newest->spool().identity().closed) {
    const bool joins = newest == nullptr && !target.request;  // A session that has scans already.
    auto sender = AddSender(newest != nullptr ? IdentityOf(newest->spool().identity().request)
                            : joins           ? IdentityOf(*target.session)
                                              : IdentityOf(*target.request),
                            joins ? target.session->last_sequence() : 0);
    if (!sender.ok()) return sender.status();
  }
  resumed_ = Newest()->opened();
  is_held_ = true;
  for (SessionSender* sender : Senders()) {
    resumed_.last_stamp_ns = std::max(resumed_.last_stamp_ns, sender->opened().last_stamp_ns);
    if (sender != Newest()) sender->Close(true);
  }
  if (!options_.spool.is_replayed) StartHeld();
  return absl::OkStatus();
}

void ScanStream::Impl::StartHeld() {
  if (!std::exchange(is_held_, false)) return;
  for (SessionSender* sender : Senders()) sender->Start();
}

absl::Status ScanStream::Impl::CheckNewest(const SpoolTarget& target) {
  const bool to_resume = !target.request && !target.session;
  SessionSender* const newest = Newest();
  if (newest == nullptr && !to_resume) return absl::OkStatus();
  if (newest == nullptr) {
    return absl::NotFoundError(absl::StrCat("nothing to resume in the spool ", options_.spool_dir,
                                            ": begin with Client::OpenSpool"));
  }
  const SpoolIdentity identity = newest->spool().identity();
  if (target.request && target.request->robot() != identity.request.robot()) {
    return absl::FailedPreconditionError(absl::StrCat(
        "the spool ", options_.spool_dir, " holds scans of robot ", identity.request.robot(),
        ": name another folder for ", target.request->robot()));
  }
  if (target.session && target.session->id() != identity.session) {
    return absl::FailedPreconditionError(
        absl::StrCat("the spool ", options_.spool_dir, " holds scans of session ", identity.session,
                     ": send those first with Client::ResumeScanStream, or name another folder"));
  }
  if (identity.session.empty()) return absl::OkStatus();
  const std::optional<v1::Session> known = AskOnce({identity.session, identity.created_ns});
  if (!known) return absl::OkStatus();
  const uint64_t last = known->last_sequence() + identity.base;
  const bool over = known->state() == v1::Session::FINISHED && identity.unsure_from == 0 &&
                    last == newest->spool().written();
  if (over) {
    ReportEvent(
        absl::StrCat("session ", identity.session, " was finished with all that was in the spool"));
    if (absl::Status status = newest->spool().Remove(); !status.ok()) return status;
    {
      MutexLock lock(&mutex_);
      senders_.pop_back();
    }
    if (!to_resume) return absl::OkStatus();
    return absl::AlreadyExistsError(absl::StrCat(
        "session ", identity.session,
        " was finished with all that was in the spool: begin another ", "with Client::OpenSpool"));
  }
  const absl::Status expected = newest->Expect(*known);
  const bool may_change = options_.spool.if_session_is_gone == IfSessionIsGone::kNewSession &&
                          newest->MayMoveOn(*known);
  return may_change && absl::IsFailedPrecondition(expected) ? absl::OkStatus() : expected;
}

std::optional<v1::Session> ScanStream::Impl::AskOnce(const OpenedSession& session) const {
  v1::GetSessionRequest request;
  request.set_session(session.id);
  v1::Session known;
  const absl::Status status =
      link_->NewCall(options_.spool.attempt_timeout_s)->GetSession(request, &known);
  const bool is_gone = absl::IsNotFound(status) || (status.ok() && IsAnother(known, session));
  if (is_gone) return v1::Session();
  if (!status.ok()) return std::nullopt;
  return known;
}

DiskSpool::Options ScanStream::Impl::SpoolOptionsFor() const {
  DiskSpool::Options options;
  options.segment_bytes = std::min(kLargestSegment, options_.spool.max_bytes / kSegments);
  const uint64_t disk_bytes = io::SpaceOf(options_.spool_dir).total_bytes;
  if (disk_bytes > 0) {
    options.segment_bytes = std::min(options.segment_bytes, disk_bytes / kSegments);
  }
  options.sync_interval_s = options_.spool.sync_interval_s;
  options.disk = disk_;
  return options;
}

absl::StatusOr<SessionSender*> ScanStream::Impl::AddSender(const SpoolIdentity& identity,
                                                           uint64_t last_sequence) {
  auto spool = folder_->Add(identity, SpoolOptionsFor());
  if (!spool.ok()) return spool.status();
  if (last_sequence > 0) {
    if (absl::Status status = (*spool)->Skip(0, last_sequence); !status.ok()) return status;
  }
  AdoptSpool(*std::move(spool));
  return Newest();
}

void ScanStream::Impl::AdoptSpool(std::unique_ptr<SessionSpool> spool) {
  auto sender =
      std::make_unique<SessionSender>(link_.get(), std::move(spool), options_, MakeHost());
  MutexLock lock(&mutex_);
  senders_.push_back(std::move(sender));
}

SessionSender::Host ScanStream::Impl::MakeHost() {
  SessionSender::Host host;
  host.acked = [this](const ScanAck& ack) {
    MutexLock lock(&callback_mutex_);
    if (options_.on_ack) options_.on_ack(ack);
  };
  host.event = [this](const std::string& event) { ReportEvent(event); };
  host.changed = [this] {
    MutexLock lock(&mutex_);
    ++changes_;
    changed_.SignalAll();
  };
  host.behind = [this](SessionSender* sender) { TurnFrom(sender); };
  return host;
}

void ScanStream::Impl::ReportEvent(const std::string& event) {
  MutexLock lock(&callback_mutex_);
  if (options_.on_event) options_.on_event(event);
}

std::vector<SessionSender*> ScanStream::Impl::Senders() const {
  MutexLock lock(&mutex_);
  std::vector<SessionSender*> senders;
  for (const auto& sender : senders_) senders.push_back(sender.get());
  return senders;
}

SessionSender* ScanStream::Impl::Newest() const {
  MutexLock lock(&mutex_);
  return senders_.empty() ? nullptr : senders_.back().get();
}

SessionId ScanStream::Impl::session() const {
  MutexLock lock(&mutex_);
  return senders_.back()->session();
}

void ScanStream::Impl::TurnFrom(SessionSender* sender) {
  {
    MutexLock lock(&mutex_);
    behind_ = sender;
  }
  // Else a Push holds it, maybe until there is room, which takes the sender's own thread.
  if (!push_mutex_.TryLock()) return;
  TurnIfDue();
  push_mutex_.Unlock();
}

void ScanStream::Impl::TurnIfDue() {
  SessionSender* sender = nullptr;
  {
    MutexLock lock(&mutex_);
    const SessionSender* const behind = std::exchange(behind_, nullptr);
    if (stopping_ || finishing_ || senders_.empty() || senders_.back().get() != behind) return;
    sender = senders_.back().get();
  }
  if (!sender->behind()) return;
  SpoolIdentity identity = sender->spool().identity();
  const SpoolIdentity next = IdentityOf(identity.request);
  identity.closed = true;
  absl::Status status = sender->spool().SetIdentity(identity);
  absl::StatusOr<SessionSender*> added = status.ok() ? AddSender(next, 0) : status;
  if (!added.ok()) return ReportEvent("no new session: " + std::string(added.status().message()));
  ReportEvent(
      absl::StrCat("session ", identity.session, " is filled up; new scans go into another"));
  sender->Close(true);
  (*added)->Start();
}

absl::StatusOr<std::string> ScanStream::Impl::BytesOf(int64_t end_stamp_ns,
                                                      PointPayload payload) const {
  absl::StatusOr<PointPayload> prepared = Prepare(std::move(payload), options_);
  if (!prepared.ok()) return prepared.status();
  v1::ScanMessage scan;
  scan.set_end_stamp_ns(end_stamp_ns);
  *scan.mutable_cloud() = convert::ToMessage(*std::move(prepared));
  return scan.SerializeAsString();
}

std::optional<bool> ScanStream::Impl::IsNewest(int64_t end_stamp_ns, PointPayload payload) const {
  MutexLock pushing(&push_mutex_);
  const SessionSpool& spool = Newest()->spool();
  const auto newest = spool.Read(spool.written());
  if (!newest.ok()) return std::nullopt;
  const auto bytes = BytesOf(end_stamp_ns, std::move(payload));
  return bytes.ok() && *bytes == *newest;
}

absl::Status ScanStream::Impl::Push(int64_t end_stamp_ns, PointPayload payload) {
  auto bytes = BytesOf(end_stamp_ns, std::move(payload));
  if (!bytes.ok()) return bytes.status();
  MutexLock pushing(&push_mutex_);
  StartHeld();
  for (FullDisk full;;) {
    RemoveFinishedSenders();
    if (absl::Status status = WaitForRoom(bytes->size()); !status.ok()) return status;
    TurnIfDue();
    {
      MutexLock lock(&mutex_);
      full.changes = changes_;
    }
    const bool is_told = !full.error.ok();
    if (folder_ == nullptr) return Newest()->Push(end_stamp_ns, *std::move(bytes));
    full.error = Newest()->Push(end_stamp_ns, *bytes);
    if (!absl::IsResourceExhausted(full.error)) return full.error;
    const bool waits = options_.spool.when_full == WhenFull::kWait;
    if (waits && !is_told) ReportEvent("waits for room: " + std::string(full.error.message()));
    if (absl::Status status = WaitForDisk(full); !status.ok()) return status;
  }
}

uint64_t ScanStream::Impl::SpoolBytes() const {
  uint64_t bytes = 0;
  for (const auto& sender : senders_) bytes += sender->spool().bytes();
  return bytes;
}

bool ScanStream::Impl::HasRoom(uint64_t bytes) const {
  if (folder_ == nullptr) {
    return senders_.back()->backlog() < std::max<size_t>(options_.window, 1);
  }
  return SpoolBytes() + bytes + io::kRecordHeaderBytes <= options_.spool.max_bytes;
}

absl::Status ScanStream::Impl::WaitForRoom(uint64_t bytes) {
  MutexLock lock(&mutex_);
  for (;;) {
    if (stopping_) return absl::CancelledError("the stream was given up");
    const absl::Status ended = senders_.back()->ended().value_or(absl::OkStatus());
    if (!ended.ok()) return ended;
    if (finishing_) return absl::FailedPreconditionError("the stream was finished");
    if (HasRoom(bytes)) return absl::OkStatus();
    if (folder_ == nullptr) {
      changed_.Wait(&mutex_);
    } else if (absl::Status status = MakeRoom(bytes); !status.ok()) {
      return status;
    }
  }
}

absl::Status ScanStream::Impl::MakeRoom(uint64_t bytes) {
  const std::string full = absl::StrCat("the spool ", options_.spool_dir,
                                        " is full: ", options_.spool.max_bytes, " bytes");
  if (bytes > options_.spool.max_bytes / 2) {
    return absl::ResourceExhaustedError(absl::StrCat(full, " are too few for a scan of ", bytes));
  }
  switch (options_.spool.when_full) {
    case WhenFull::kRefuse:
      return absl::ResourceExhaustedError(
          full +
          "; the server is out of reach or too slow: raise max_bytes, push less often, or "
          "let the oldest scans go with WhenFull::kDropOldest");
    case WhenFull::kDropOldest: {
      if (!DropOldest()) return absl::ResourceExhaustedError(full + "; raise max_bytes");
      return absl::OkStatus();
    }
    case WhenFull::kWait:
      break;
  }
  const WaitClock& clock = link_->clock();
  const uint64_t before = SpoolBytes();
  const auto moved = [&]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    return stopping_ || senders_.back()->ended() || SpoolBytes() < before || !IsStuck();
  };
  if (!IsStuck()) {
    changed_.Wait(&mutex_);
    return absl::OkStatus();
  }
  if (clock.WaitUntil(&changed_, &mutex_, clock.Now() + kHopeless_s, moved))
    return absl::OkStatus();
  return absl::ResourceExhaustedError(
      full +
      " hold scans that the server has but did not make durable for a minute: raise max_bytes");
}

bool ScanStream::Impl::IsStuck() const {
  return std::all_of(senders_.begin(), senders_.end(),
                     [](auto& sender) { return sender->backlog() == 0; });
}

bool ScanStream::Impl::DropOldest() {
  return std::any_of(senders_.begin(), senders_.end(),
                     [](auto& sender) { return sender->spool().DropOldest(); });
}

absl::Status ScanStream::Impl::WaitForDisk(FullDisk& full) {
  MutexLock lock(&mutex_);
  if (options_.spool.when_full == WhenFull::kRefuse) return full.error;
  if (options_.spool.when_full == WhenFull::kDropOldest) {
    return DropOldest() ? absl::OkStatus() : full.error;
  }
  const WaitClock& clock = link_->clock();
  const double now = clock.Now();
  if (!IsStuck()) {
    full.idle_since.reset();
  } else if (!full.idle_since) {
    full.idle_since = now;
  } else if (now - *full.idle_since >= kHopeless_s) {
    return absl::ResourceExhaustedError(
        absl::StrCat(full.error.message(),
                     ". No scan in the spool became durable for a minute: its disk takes "
                     "the scans of an outage and 200 more"));
  }
  clock.WaitUntil(&changed_, &mutex_, now + kLookAtDiskEvery_s,
                  [&]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
                    return stopping_ || finishing_ || changes_ != full.changes;
                  });
  return absl::OkStatus();
}

// Removes senders that have nothing left to do. Not from a thread of theirs.
void ScanStream::Impl::RemoveFinishedSenders() {
  std::vector<std::unique_ptr<SessionSender>> done;
  {
    MutexLock lock(&mutex_);
    for (auto& sender : senders_) {
      if (sender == senders_.back() || !sender->finished()) continue;
      AddUp(sender->stats(), stats_of_removed_);
      done.push_back(std::move(sender));
    }
    senders_.erase(std::remove(senders_.begin(), senders_.end(), nullptr), senders_.end());
  }
}

absl::Status ScanStream::Impl::Close(bool conclude) {
  {
    MutexLock lock(&mutex_);
    finishing_ = true;  // Wakes a Push that waits.
    changed_.SignalAll();
  }
  {
    MutexLock pushing(&push_mutex_);  // No sender is added from here on.
    StartHeld();
    for (SessionSender* sender : Senders()) sender->Close(conclude || sender != Newest());
  }
  MutexLock lock(&mutex_);
  while (!std::all_of(senders_.begin(), senders_.end(),
                      [](auto& sender) { return sender->ended(); })) {
    if (stopping_) return absl::CancelledError("the stream was given up");
    changed_.Wait(&mutex_);
  }
  for (auto& sender : senders_) {
    if (sender->ended()->ok()) continue;
    return stopping_ ? absl::CancelledError("the stream was given up") : *sender->ended();
  }
  return absl::OkStatus();
}

absl::StatusOr<SessionStatus> ScanStream::Impl::FinishSession() {
  if (absl::Status status = Close(true); !status.ok()) return status;
  MutexLock lock(&mutex_);
  return convert::FromMessage(*senders_.back()->finished());
}

ScanStreamStats ScanStream::Impl::stats() const {
  MutexLock lock(&mutex_);
  ScanStreamStats sum = stats_of_removed_;
  for (const auto& sender : senders_) AddUp(sender->stats(), sum);
  return sum;
}

}  // namespace isthmus::client
