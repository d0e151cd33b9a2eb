#include "storage/sqlite/sqlite_store.h"

#include <absl/strings/str_cat.h>

#include <cstdint>
#include <filesystem>
#include <system_error>
#include <utility>

#include "core/codec/quantized.h"
#include "core/io/directory_lock.h"
#include "storage/batch_rules.h"
#include "storage/record_rules.h"
#include "storage/records/submap_codec.h"
#include "storage/revision_log.h"
#include "storage/sqlite/connection_pool.h"
#include "storage/sqlite/group_commit.h"
#include "storage/sqlite/migrations.h"
#include "storage/sqlite/open_marker.h"
#include "storage/sqlite/rows.h"

namespace isthmus::storage {
namespace {

std::string DatabaseIn(const std::string& directory) { return directory + "/isthmus.db"; }

uint64_t BytesOf(const std::string& path) {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  return error ? 0 : size;
}

// Enough for a query, an export and a matcher at a time; more would wait for the disk anyway.
constexpr int kReaders = 3;

// One connection writes, for all who come at a time together; a few others read. In WAL mode
// readers see the last commit and wait for no writer, whose commits wait for the disk. Submaps are
// packed and unpacked outside of both.
class SqliteStore : public MapStore {
 public:
  SqliteStore(const std::string& directory, std::unique_ptr<io::DirectoryLock> lock,
              std::unique_ptr<Connection> writer, std::vector<std::unique_ptr<Connection>> readers,
              const SqliteOptions& options)
      : lock_(std::move(lock)),
        path_(DatabaseIn(directory)),
        options_(options),
        readers_(std::move(readers)),
        writer_(std::move(writer)),
        marker_(directory) {}

  absl::Status Write(const WriteBatch& batch) override {
    std::vector<SubmapRow> encoded;
    for (const auto& submap : batch.submaps) {
      absl::StatusOr<std::string> blob = EncodeSubmap(*submap, options_.resolution_m);
      // A submap that cannot be encoded breaks a rule, and CheckBatch says it better.
      if (!blob.ok() && !absl::IsInvalidArgument(blob.status())) return blob.status();
      encoded.push_back({Summarize(*submap), blob.ok() ? *std::move(blob) : std::string()});
    }
    return writer_.Run([&](Connection& database) { return AddBatch(database, batch, encoded); });
  }

  using MapStore::DeleteSession;
  absl::Status DeleteSession(const SessionId& session, const std::vector<Event>& events) override {
    if (absl::Status status = CheckEvents(events); !status.ok()) return status;
    return writer_.Run([&](Connection& database) -> absl::Status {
      absl::StatusOr<bool> removed = RemoveSession(database, session);
      if (!removed.ok()) return removed.status();
      return *removed ? AddEvents(database, events) : UnknownSession(session);
    });
  }

  absl::StatusOr<SessionRecord> GetSession(const SessionId& session) const override {
    const ConnectionPool::Lease reader = readers_.Borrow();
    absl::StatusOr<std::optional<SessionRecord>> record = FindSession(*reader, session);
    if (!record.ok()) return record.status();
    if (!*record) return UnknownSession(session);
    return **std::move(record);
  }

  absl::StatusOr<std::vector<SessionRecord>> ListSessions() const override {
    return SelectSessions(*readers_.Borrow());
  }

  StoreSize SizeOnDisk() const override { return {BytesOf(path_), BytesOf(path_ + "-wal")}; }

  absl::StatusOr<uint64_t> StoredBytes(const SessionId& session) const override {
    return WithSession<uint64_t>(session, SumBytes);
  }

  absl::StatusOr<std::vector<TrajectoryEntry>> GetTrajectory(
      const SessionId& session) const override {
    return WithSession<std::vector<TrajectoryEntry>>(session, SelectTrajectory);
  }

  absl::StatusOr<Checkpoint> GetCheckpoint(const SessionId& session) const override {
    auto found = WithSession<std::optional<Checkpoint>>(session, FindCheckpoint);
    if (!found.ok()) return found.status();
    if (!*found) return NoCheckpoint(session);
    (*found)->session = session;
    return **std::move(found);
  }

  absl::StatusOr<std::shared_ptr<const Submap>> GetSubmap(const SubmapId& id) const override {
    absl::StatusOr<SubmapRow> row =
        AtOneMoment<SubmapRow>([&](Connection& reader) { return FindSubmap(reader, id); });
    if (!row.ok()) return row.status();
    return UnpackSubmap(*row);
  }

  absl::StatusOr<std::vector<SubmapInfo>> ListSubmaps(
      const std::optional<SessionId>& session) const override {
    if (!session) return SelectSubmaps(*readers_.Borrow(), std::nullopt);
    return WithSession<std::vector<SubmapInfo>>(*session, SelectSubmaps);
  }

  absl::StatusOr<std::vector<SubmapInfo>> FindSubmaps(const SessionId& session,
                                                      const Box& box_odom) const override {
    auto infos = WithSession<std::vector<SubmapInfo>>(
        session,
        [&](Connection& reader, int64_t key) { return SelectSubmapsNear(reader, key, box_odom); });
    if (!infos.ok()) return infos;
    std::erase_if(*infos, [&](const SubmapInfo& info) {
      return !Transform(info.T_odom_submap, info.bounds).Intersects(box_odom);
    });
    return infos;
  }

  absl::StatusOr<std::vector<Match>> ListMatches() const override {
    return AtOneMoment<std::vector<Match>>(SelectMatches);
  }

  absl::StatusOr<std::vector<ManualDecision>> ListManualDecisions() const override {
    return AtOneMoment<std::vector<ManualDecision>>(SelectManualDecisions);
  }

  absl::StatusOr<std::vector<LoopClosure>> ListLoops() const override {
    return AtOneMoment<std::vector<LoopClosure>>(SelectLoops);
  }

  absl::StatusOr<std::vector<Anchor>> ListAnchors() const override {
    return AtOneMoment<std::vector<Anchor>>(SelectAnchors);
  }

  absl::StatusOr<std::optional<Datum>> GetDatum() const override {
    return AtOneMoment<std::optional<Datum>>(SelectDatum);
  }

  absl::StatusOr<MapRevision> LatestRevision() const override {
    return AtOneMoment<MapRevision>(SelectLatestRevision);
  }

  absl::StatusOr<std::vector<RevisionInfo>> ListRevisions(int limit) const override {
    return AtOneMoment<std::vector<RevisionInfo>>(
        [&](Connection& reader) { return SelectRevisions(reader, limit); });
  }

  absl::StatusOr<std::vector<std::pair<int64_t, SubmapMove>>> ListMoves(int64_t from,
                                                                        int64_t to) const override {
    using Moves = std::vector<std::pair<int64_t, SubmapMove>>;
    return AtOneMoment<Moves>([&](Connection& reader) -> absl::StatusOr<Moves> {
      absl::StatusOr<int64_t> oldest = OldestComparableRevision(reader);
      if (!oldest.ok()) return oldest.status();
      absl::StatusOr<int64_t> latest = LatestRevisionNumber(reader);
      if (!latest.ok()) return latest.status();
      if (auto status = CheckRange(from, to, *oldest, *latest); !status.ok()) return status;
      return SelectMoves(reader, from, to);
    });
  }

  absl::StatusOr<EventPage> ListEvents(const EventQuery& query) const override {
    return AtOneMoment<EventPage>([&](Connection& reader) { return SelectEvents(reader, query); });
  }

  absl::Status PutFeatures(const FeatureBlob& blob) override {
    return writer_.Run([&](Connection& database) { return PutFeatureRow(database, blob); });
  }

  absl::StatusOr<std::string> GetFeatures(const SubmapId& submap,
                                          const std::string& kind) const override {
    return AtOneMoment<std::string>(
        [&](Connection& reader) { return FindFeatures(reader, submap, kind); });
  }

 private:
  // Runs `read` so that all its statements see the same commit.
  template <typename T, typename Read>
  absl::StatusOr<T> AtOneMoment(const Read& read) const {
    const ConnectionPool::Lease reader = readers_.Borrow();
    Transaction snapshot(*reader, Transaction::Kind::kRead);
    if (!snapshot.status().ok()) return snapshot.status();
    return read(*reader);
  }

  // `read` with the key of the session; NotFound for an unknown one.
  template <typename T, typename Read>
  absl::StatusOr<T> WithSession(const SessionId& session, const Read& read) const {
    return AtOneMoment<T>([&](Connection& reader) -> absl::StatusOr<T> {
      absl::StatusOr<std::optional<int64_t>> key = FindSessionKey(reader, session);
      if (!key.ok()) return key.status();
      if (!*key) return UnknownSession(session);
      return read(reader, **key);
    });
  }

  // Constant after construction. Destroyed last: the database is closed before the lock is let go.
  const std::unique_ptr<io::DirectoryLock> lock_;
  const std::string path_;
  const SqliteOptions options_;
  mutable ConnectionPool readers_;
  GroupCommit writer_;
  const OpenMarker marker_;  // Goes first.
};

// SQLite takes a database without a byte for a new one and throws its log away. None of ours is
// ever so: it was cut off, and what can be rescued is in the log.
absl::Status CheckNotCutOff(const std::string& directory, const std::string& path) {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error || size > 0) return absl::OkStatus();
  const std::uintmax_t log = std::filesystem::file_size(path + "-wal", error);
  if ((error || log == 0) && !OpenMarker::IsIn(directory)) return absl::OkStatus();
  return absl::DataLossError(
      absl::StrCat(path,
                   " is empty, but there was a map in it: it was cut off. Nothing was changed; "
                   "restore a backup, or move the folder away to begin a new map"));
}

absl::StatusOr<std::unique_ptr<Connection>> OpenConnection(const std::string& path,
                                                           const std::string& pragmas) {
  absl::StatusOr<std::unique_ptr<Connection>> connection = Connection::Open(path);
  if (!connection.ok()) return connection.status();
  if (absl::Status status = (*connection)->Execute(pragmas); !status.ok()) return status;
  return connection;
}

}  // namespace

absl::StatusOr<std::unique_ptr<MapStore>> OpenSqliteStore(const std::string& directory,
                                                          const SqliteOptions& options) {
  if (!(options.resolution_m >= codec::kMinResolutionM &&
        options.resolution_m <= codec::kMaxResolutionM)) {
    return absl::InvalidArgumentError(
        absl::StrCat("the resolution of stored submaps must be ", codec::kMinResolutionM, " to ",
                     codec::kMaxResolutionM, " m; it is ", options.resolution_m));
  }
  absl::StatusOr<std::unique_ptr<io::DirectoryLock>> lock = io::DirectoryLock::Acquire(directory);
  if (!lock.ok()) return lock.status();
  const std::string path = DatabaseIn(directory);
  if (absl::Status status = CheckNotCutOff(directory, path); !status.ok()) return status;
  const std::string missing = MissingLog(directory);
  if (!missing.empty() && options.on_problem) options.on_problem(missing);
  absl::StatusOr<std::unique_ptr<Connection>> writer = OpenConnection(path, "");
  if (!writer.ok()) return writer.status();
  // Before anything is changed, the journal mode and what lies in the log included.
  absl::Status status = (*writer)->SetCheckpointOnClose(false);
  if (status.ok()) status = CheckSchema(**writer);
  if (status.ok()) status = (*writer)->SetCheckpointOnClose(true);
  if (!status.ok()) return status;
  constexpr char kWriterPragmas[] =
      "PRAGMA journal_mode = WAL; PRAGMA journal_size_limit = 67108864; PRAGMA foreign_keys = ON; "
      "PRAGMA temp_store = MEMORY; PRAGMA synchronous = ";
  const char* synchronous = options.sync_every_commit ? "FULL" : "NORMAL";
  status = (*writer)->Execute(absl::StrCat(kWriterPragmas, synchronous));
  if (status.ok()) status = Migrate(**writer);
  if (!status.ok()) return status;
  // Begins the log anew, so that nothing of a torn end stays in it. It is as good with it.
  (*writer)->Execute("PRAGMA wal_checkpoint(TRUNCATE)").IgnoreError();
  std::vector<std::unique_ptr<Connection>> readers;
  for (int i = 0; i < kReaders; ++i) {
    auto reader = OpenConnection(path, "PRAGMA query_only = ON");
    if (!reader.ok()) return reader.status();
    readers.push_back(*std::move(reader));
  }
  return std::make_unique<SqliteStore>(directory, *std::move(lock), *std::move(writer),
                                       std::move(readers), options);
}

}  // namespace isthmus::storage
