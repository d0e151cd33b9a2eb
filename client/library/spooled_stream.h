// A stream that keeps its scans on disk. Private to the library.
#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "client/library/link.h"
#include "client/library/scan_stream_impl.h"
#include "client/library/spool_folder.h"
#include "client/library/spool_lane.h"

namespace isthmus::client {

// Whose scans are to be pushed.
struct SpoolWish {
  // A new session if the spool holds none; else the spool's must be of this robot.
  std::optional<v1::CreateSessionRequest> request = {};
  // That very session, as the server knows it.
  std::optional<v1::Session> session = {};
  // Neither: whatever the spool holds.
};

// One lane per session of the spool: the last takes new scans, the others are filled up at the
// server, finished and removed. Thread safe.
class SpooledStream final : public ScanStream::Impl {
 public:
  // Errors of Client::OpenScanStream, ResumeScanStream and OpenSpool.
  static absl::StatusOr<std::unique_ptr<SpooledStream>> Open(std::shared_ptr<Client::Link> link,
                                                             const ScanStreamOptions& options,
                                                             const SpoolWish& wish);
  ~SpooledStream() override;

  absl::Status Push(int64_t end_stamp_ns, PointPayload payload) override;
  absl::Status Finish() override { return Close(false); }
  absl::StatusOr<Session> FinishSession() override;
  ScanStreamStats stats() const override;
  SpoolState resumed() const override { return resumed_; }
  SessionId session() const override;

 private:
  SpooledStream(std::shared_ptr<Client::Link> link, const ScanStreamOptions& options,
                std::unique_ptr<SpoolFolder> folder);

  absl::Status Load(const SpoolWish& wish);
  absl::Status CheckNewest(const SpoolWish& wish);
  // What the server says of it, if it answers soon.
  std::optional<v1::Session> AskOnce(const std::string& session) const;
  absl::StatusOr<SpoolLane*> AddLane(const SpoolIdentity& identity);
  void Adopt(std::unique_ptr<SessionSpool> spool);
  SpoolLane::Host MakeHost();
  SessionSpool::Options SpoolOptionsFor() const;

  // New scans go into a new session from now on, if `lane` is still the one that takes them.
  void TurnTo(SpoolLane* lane);
  absl::Status WaitForRoom(uint64_t bytes);
  absl::Status MakeRoom(std::unique_lock<std::mutex>& lock, uint64_t bytes);
  absl::Status Close(bool conclude);
  uint64_t SpoolBytes() const;  // With mutex_ held.
  SpoolLane* Newest() const;
  void Reap();
  void Tell(const std::string& event);

  const std::shared_ptr<Client::Link> link_;
  const ScanStreamOptions options_;
  const std::unique_ptr<SpoolFolder> folder_;
  SpoolState resumed_;

  std::mutex callback_mutex_;  // Held while the robot's functions are called.
  std::mutex push_mutex_;      // Held while a scan is taken; taken before mutex_.

  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  // Guarded by mutex_ from here.
  bool finishing_ = false;
  bool stopping_ = false;                          // The destructor has begun.
  ScanStreamStats reaped_;                         // Of lanes that are gone.
  std::vector<std::unique_ptr<SpoolLane>> lanes_;  // The last takes new scans.
};

}  // namespace isthmus::client
