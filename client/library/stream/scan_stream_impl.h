// The stream behind a ScanStream. Private to the library.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "client/library/spool/spool_folder.h"
#include "client/library/stream/scan_stream.h"
#include "client/library/stream/session_link.h"
#include "client/library/stream/session_sender.h"
#include "core/concurrency/mutex.h"

namespace isthmus::client {

// The session whose scans are to be pushed.
struct SpoolTarget {
  // A new session if the spool holds none; else the spool's must be of this robot.
  std::optional<v1::CreateSessionRequest> request = {};
  // Exactly this session, as the server knows it.
  std::optional<v1::Session> session = {};
  // Neither: whatever the spool holds.
  const io::DiskCalls* disk = &io::DiskCalls::System();
};

// Compressed if `options` ask for it. InvalidArgument when that cannot be done.
absl::StatusOr<PointPayload> Prepare(PointPayload payload, const ScanStreamOptions& options,
                                     int newest_version = kQuantizedVersion);

// One sender per session of the spool: the last takes new scans, the others are filled up at the
// server, finished and removed. In memory there is one. Thread safe, its functions are those of
// ScanStream.
class ScanStream::Impl final {
 public:
  // Errors of Client::OpenScanStream, ResumeScanStream and OpenSpool.
  static absl::StatusOr<std::unique_ptr<ScanStream>> Open(std::shared_ptr<SessionLink> link,
                                                          const ScanStreamOptions& options,
                                                          const SpoolTarget& target);
  ~Impl();

  absl::Status Push(int64_t end_stamp_ns, PointPayload payload);
  absl::Status Finish() { return Close(false); }
  absl::StatusOr<SessionStatus> FinishSession();
  void GiveUp();
  ScanStreamStats stats() const;
  SpoolState resumed() const { return resumed_; }
  std::optional<bool> IsNewest(int64_t end_stamp_ns, PointPayload payload) const;
  SessionId session() const;

 private:
  Impl(std::shared_ptr<SessionLink> link, const ScanStreamOptions& options)
      : link_(std::move(link)), options_(options) {}

  // A scan as it is kept and sent.
  absl::StatusOr<std::string> BytesOf(int64_t end_stamp_ns, PointPayload payload) const;
  absl::Status OpenMemory(const SpoolTarget& target);
  absl::Status OpenFolder(const SpoolTarget& target);
  absl::Status CheckNewest(const SpoolTarget& target) ABSL_EXCLUSIVE_LOCKS_REQUIRED(push_mutex_);
  // The session as the server knows it, if it answers soon.
  std::optional<v1::Session> AskOnce(const OpenedSession& session) const;
  // The first scan gets the number after `last_sequence`.
  absl::StatusOr<SessionSender*> AddSender(const SpoolIdentity& identity, uint64_t last_sequence)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(push_mutex_);
  void AdoptSpool(std::unique_ptr<SessionSpool> spool) ABSL_EXCLUSIVE_LOCKS_REQUIRED(push_mutex_);
  SessionSender::Host MakeHost();
  DiskSpool::Options SpoolOptionsFor() const;

  // Has the senders begin, once something is asked of them.
  void StartHeld() ABSL_EXCLUSIVE_LOCKS_REQUIRED(push_mutex_);

  // New scans go into a new session from now on, if `sender` is the one that takes them; from the
  // next on if one is being taken.
  void TurnFrom(SessionSender* sender);
  void TurnIfDue() ABSL_EXCLUSIVE_LOCKS_REQUIRED(push_mutex_);
  bool HasRoom(uint64_t bytes) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  absl::Status WaitForRoom(uint64_t bytes) ABSL_EXCLUSIVE_LOCKS_REQUIRED(push_mutex_);
  absl::Status MakeRoom(uint64_t bytes) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // A scan that the disk had no room for.
  struct FullDisk {
    absl::Status error;
    uint64_t changes = 0;              // changes_ before it was written.
    std::optional<double> idle_since;  // When nothing was left that would make room.
  };
  // OK when it may be written again.
  absl::Status WaitForDisk(FullDisk& full);
  bool IsStuck() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  bool DropOldest() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  absl::Status Close(bool conclude);
  uint64_t SpoolBytes() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // They stay while push_mutex_ is held.
  std::vector<SessionSender*> Senders() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(push_mutex_);
  SessionSender* Newest() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(push_mutex_);
  void RemoveFinishedSenders() ABSL_EXCLUSIVE_LOCKS_REQUIRED(push_mutex_);
  void ReportEvent(const std::string& event);

  const std::shared_ptr<SessionLink> link_;
  ScanStreamOptions options_;  // Not changed once it is open.
  const io::DiskCalls* disk_ = &io::DiskCalls::System();
  std::unique_ptr<SpoolFolder> folder_;  // Null: in memory.
  SpoolState resumed_;

  Mutex callback_mutex_;  // Held while the robot's functions are called.
  // Held while a scan is taken, and while senders come and go.
  mutable Mutex push_mutex_ ABSL_ACQUIRED_BEFORE(mutex_);
  // No sender has begun: the owner compares the spool and the server's scans with its own first.
  bool is_held_ ABSL_GUARDED_BY(push_mutex_) = false;

  mutable Mutex mutex_;
  mutable CondVar changed_;
  uint64_t changes_ ABSL_GUARDED_BY(mutex_) = 0;  // Counts what senders tell.
  bool finishing_ ABSL_GUARDED_BY(mutex_) = false;
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;  // The destructor has begun.
  // Its backlog was old when the link came back; to be turned from.
  const SessionSender* behind_ ABSL_GUARDED_BY(mutex_) = nullptr;
  ScanStreamStats stats_of_removed_ ABSL_GUARDED_BY(mutex_);  // Sum over senders that are gone.
  // The last takes new scans.
  std::vector<std::unique_ptr<SessionSender>> senders_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace isthmus::client
