// A store in an SQL database: one connection writes, for all callers at a time together; a few
// others read.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "core/concurrency/mutex.h"
#include "storage/map_store.h"
#include "storage/objects/large_values.h"
#include "storage/sql/connection_pool.h"
#include "storage/sql/group_commit.h"

namespace isthmus::storage {

// InvalidArgument for a step to which coordinates cannot be rounded.
absl::Status CheckResolution(double resolution_m);

// All of MapStore's promises but SizeOnDisk. Readers see the last commit and wait for no writer,
// whose commits wait for the disk. Submaps are packed and unpacked outside of both. Reading is
// tried again where the way to the database was lost meanwhile.
class SqlStore : public MapStore {
 public:
  // The writer has the newest schema, of which rows.h speaks; submaps' coordinates are rounded to
  // `resolution_m`. Null: the writing methods are overridden. `large_values`, if any, have the
  // large values; else rows do. A store of which another one may get some later finds them by
  // `find`, which is asked once a row refers to them.
  using FindLargeValues = absl::StatusOr<std::unique_ptr<LargeValues>> (*)(Connection& reader);
  SqlStore(std::unique_ptr<Connection> writer, std::vector<std::unique_ptr<Connection>> readers,
           double resolution_m, std::unique_ptr<LargeValues> large_values = nullptr,
           FindLargeValues find = nullptr);

  absl::Status Write(const WriteBatch& batch) override;
  using MapStore::DeleteSession;
  absl::Status DeleteSession(const SessionId& session, const std::vector<Event>& events) override;
  absl::Status PutFeatures(const FeatureBlob& blob) override;

  absl::StatusOr<SessionRecord> GetSession(const SessionId& session) const override;
  absl::StatusOr<std::vector<SessionRecord>> ListSessions() const override;
  absl::StatusOr<uint64_t> StoredBytes(const SessionId& session) const override;
  absl::StatusOr<std::vector<TrajectoryEntry>> GetTrajectory(
      const SessionId& session) const override;
  absl::StatusOr<Checkpoint> GetCheckpoint(const SessionId& session) const override;
  absl::StatusOr<std::vector<MatchingProgress>> ListMatchingProgress() const override;
  absl::StatusOr<std::shared_ptr<const Submap>> GetSubmap(const SubmapId& id) const override;
  absl::StatusOr<std::vector<SubmapInfo>> ListSubmaps(
      const std::optional<SessionId>& session) const override;
  absl::StatusOr<std::vector<Match>> ListMatches() const override;
  absl::StatusOr<std::vector<ManualDecision>> ListManualDecisions() const override;
  absl::StatusOr<std::vector<LoopClosure>> ListLoops() const override;
  absl::StatusOr<std::vector<Anchor>> ListAnchors() const override;
  absl::StatusOr<std::optional<Datum>> GetDatum() const override;
  absl::StatusOr<MapRevision> LatestRevision() const override;
  absl::StatusOr<std::vector<RevisionInfo>> ListRevisions(int limit) const override;
  absl::StatusOr<std::vector<std::pair<int64_t, SubmapMove>>> ListMoves(int64_t from,
                                                                        int64_t to) const override;
  absl::StatusOr<EventPage> ListEvents(const EventQuery& query) const override;
  absl::StatusOr<std::string> GetFeatures(const SubmapId& submap,
                                          const std::string& kind) const override;

 protected:
  // Runs `read` so that all its statements see the same commit.
  template <typename T, typename Read>
  absl::StatusOr<T> AtOneMoment(const Read& read) const {
    const ConnectionPool::Lease reader = readers_.Borrow();
    absl::StatusOr<T> result = ReadOnce<T>(*reader, read);
    // Nothing was changed: a query that the connection lost can be asked again, by a new way.
    if (result.ok() || !(*reader).IsLost()) return result;
    return ReadOnce<T>(*reader, read);
  }

  // As GroupCommit::Run.
  absl::Status WriteBy(const GroupCommit::Work& work) { return writer_.Run(work); }

  LargeValues* large_values() const;  // Null where there are none (yet). Stay as long as this does.

 private:
  template <typename T, typename Read>
  static absl::StatusOr<T> ReadOnce(Connection& reader, const Read& read) {
    Transaction snapshot(reader, Transaction::Kind::kRead);
    if (!snapshot.status().ok()) return snapshot.status();
    return read(reader);
  }
  // `read` with the key of the session; NotFound for an unknown one.
  template <typename T, typename Read>
  absl::StatusOr<T> WithSession(const SessionId& session, const Read& read) const;

  // The value as its row has it, and back. By no connection: a bucket takes its time.
  absl::StatusOr<std::string> ToRow(std::string value) const;
  absl::StatusOr<std::string> FromRow(std::string in_row) const;

  const double resolution_m_;
  const FindLargeValues find_;
  mutable Mutex mutex_;
  mutable std::unique_ptr<LargeValues> large_values_ ABSL_GUARDED_BY(mutex_);  // Set once.
  mutable ConnectionPool readers_;
  GroupCommit writer_;
};

}  // namespace isthmus::storage
