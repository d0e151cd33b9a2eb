#include "storage/sql/sql_store.h"

#include <absl/strings/str_cat.h>

#include <cstdint>
#include <utility>

#include "core/codec/quantized.h"
#include "storage/batch_rules.h"
#include "storage/record_rules.h"
#include "storage/records/submap_codec.h"
#include "storage/revision_log.h"
#include "storage/sql/rows.h"

namespace isthmus::storage {

absl::Status CheckResolution(double resolution_m) {
  if (resolution_m >= codec::kMinResolutionM && resolution_m <= codec::kMaxResolutionM) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(
      absl::StrCat("the resolution of stored submaps must be ", codec::kMinResolutionM, " to ",
                   codec::kMaxResolutionM, " m; it is ", resolution_m));
}

SqlStore::SqlStore(std::unique_ptr<Connection> writer,
                   std::vector<std::unique_ptr<Connection>> readers, double resolution_m,
                   std::unique_ptr<LargeValues> large_values, FindLargeValues find)
    : resolution_m_(resolution_m),
      find_(find),
      large_values_(std::move(large_values)),
      readers_(std::move(readers)),
      writer_(std::move(writer)) {}

absl::StatusOr<std::string> SqlStore::ToRow(std::string value) const {
  LargeValues* values = large_values();
  if (values == nullptr) return value;
  return values->Put(std::move(value));
}

absl::StatusOr<std::string> SqlStore::FromRow(std::string in_row) const {
  LargeValues* values = large_values();
  if (values == nullptr && find_ != nullptr && FindReference(in_row)) {
    const ConnectionPool::Lease reader = readers_.Borrow();
    absl::StatusOr<std::unique_ptr<LargeValues>> found = find_(*reader);
    if (!found.ok()) return absl::UnavailableError(found.status().message());
    MutexLock lock(&mutex_);
    if (large_values_ == nullptr) large_values_ = *std::move(found);
    values = large_values_.get();
  }
  if (values == nullptr) return in_row;
  return values->Get(std::move(in_row));
}

LargeValues* SqlStore::large_values() const {
  MutexLock lock(&mutex_);
  return large_values_.get();
}

template <typename T, typename Read>
absl::StatusOr<T> SqlStore::WithSession(const SessionId& session, const Read& read) const {
  return AtOneMoment<T>([&](Connection& reader) -> absl::StatusOr<T> {
    absl::StatusOr<std::optional<int64_t>> key = FindSessionKey(reader, session);
    if (!key.ok()) return key.status();
    if (!*key) return UnknownSession(session);
    return read(reader, **key);
  });
}

absl::Status SqlStore::Write(const WriteBatch& batch) {
  std::vector<SubmapRow> encoded;
  for (const auto& submap : batch.submaps) {
    absl::StatusOr<std::string> blob = EncodeSubmap(*submap, resolution_m_);
    // A submap that cannot be encoded breaks a rule, and CheckBatch says it better.
    if (!blob.ok() && !absl::IsInvalidArgument(blob.status())) return blob.status();
    if (blob.ok()) blob = ToRow(*std::move(blob));
    if (absl::IsUnavailable(blob.status())) return blob.status();
    encoded.push_back({Summarize(*submap), blob.ok() ? *std::move(blob) : std::string()});
  }
  const auto add = [&encoded](const WriteBatch& all) {
    return [&](Connection& database) { return AddBatch(database, all, encoded); };
  };
  if (large_values() == nullptr || batch.checkpoints.empty()) return writer_.Run(add(batch));
  WriteBatch in_rows = batch;
  for (Checkpoint& checkpoint : in_rows.checkpoints) {
    if (!checkpoint.data) continue;
    absl::StatusOr<std::string> row = ToRow(*std::move(checkpoint.data));
    if (!row.ok()) return row.status();
    checkpoint.data = *std::move(row);
  }
  return writer_.Run(add(in_rows));
}

absl::Status SqlStore::DeleteSession(const SessionId& session, const std::vector<Event>& events) {
  if (absl::Status status = CheckEvents(events); !status.ok()) return status;
  return writer_.Run([&](Connection& database) -> absl::Status {
    absl::StatusOr<bool> removed = RemoveSession(database, session);
    if (!removed.ok()) return removed.status();
    return *removed ? AddEvents(database, events) : UnknownSession(session);
  });
}

absl::StatusOr<SessionRecord> SqlStore::GetSession(const SessionId& session) const {
  auto record = AtOneMoment<std::optional<SessionRecord>>(
      [&](Connection& reader) { return FindSession(reader, session); });
  if (!record.ok()) return record.status();
  if (!*record) return UnknownSession(session);
  return **std::move(record);
}

absl::StatusOr<std::vector<SessionRecord>> SqlStore::ListSessions() const {
  return AtOneMoment<std::vector<SessionRecord>>(SelectSessions);
}

absl::StatusOr<uint64_t> SqlStore::StoredBytes(const SessionId& session) const {
  return WithSession<uint64_t>(session, SumBytes);
}

absl::StatusOr<std::vector<TrajectoryEntry>> SqlStore::GetTrajectory(
    const SessionId& session) const {
  return WithSession<std::vector<TrajectoryEntry>>(session, SelectTrajectory);
}

absl::StatusOr<Checkpoint> SqlStore::GetCheckpoint(const SessionId& session) const {
  auto found = WithSession<std::optional<Checkpoint>>(session, FindCheckpoint);
  if (!found.ok()) return found.status();
  if (!*found) return NoCheckpoint(session);
  Checkpoint checkpoint = **std::move(found);
  checkpoint.session = session;
  if (!checkpoint.data) return checkpoint;
  absl::StatusOr<std::string> data = FromRow(*std::move(checkpoint.data));
  if (!data.ok() && !absl::IsDataLoss(data.status())) return data.status();
  checkpoint.data = data.ok() ? std::optional(*std::move(data)) : std::nullopt;
  return checkpoint;
}

absl::StatusOr<std::vector<MatchingProgress>> SqlStore::ListMatchingProgress() const {
  return AtOneMoment<std::vector<MatchingProgress>>(SelectMatchingProgress);
}

absl::StatusOr<std::shared_ptr<const Submap>> SqlStore::GetSubmap(const SubmapId& id) const {
  absl::StatusOr<SubmapRow> row =
      AtOneMoment<SubmapRow>([&](Connection& reader) { return FindSubmap(reader, id); });
  if (!row.ok()) return row.status();
  absl::StatusOr<std::string> blob = FromRow(std::move(row->blob));
  if (absl::IsDataLoss(blob.status())) return DamagedSubmap(id, blob.status());
  if (!blob.ok()) return blob.status();
  row->blob = *std::move(blob);
  return UnpackSubmap(*row);
}

absl::StatusOr<std::vector<SubmapInfo>> SqlStore::ListSubmaps(
    const std::optional<SessionId>& session) const {
  using Infos = std::vector<SubmapInfo>;
  if (session) return WithSession<Infos>(*session, SelectSubmaps);
  return AtOneMoment<Infos>([](Connection& reader) { return SelectSubmaps(reader, std::nullopt); });
}

absl::StatusOr<std::vector<Match>> SqlStore::ListMatches() const {
  return AtOneMoment<std::vector<Match>>(SelectMatches);
}

absl::StatusOr<std::vector<ManualDecision>> SqlStore::ListManualDecisions() const {
  return AtOneMoment<std::vector<ManualDecision>>(SelectManualDecisions);
}

absl::StatusOr<std::vector<LoopClosure>> SqlStore::ListLoops() const {
  return AtOneMoment<std::vector<LoopClosure>>(SelectLoops);
}

absl::StatusOr<std::vector<Anchor>> SqlStore::ListAnchors() const {
  return AtOneMoment<std::vector<Anchor>>(SelectAnchors);
}

absl::StatusOr<std::optional<Datum>> SqlStore::GetDatum() const {
  return AtOneMoment<std::optional<Datum>>(SelectDatum);
}

absl::StatusOr<MapRevision> SqlStore::LatestRevision() const {
  return AtOneMoment<MapRevision>(SelectLatestRevision);
}

absl::StatusOr<std::vector<RevisionInfo>> SqlStore::ListRevisions(int limit) const {
  return AtOneMoment<std::vector<RevisionInfo>>(
      [&](Connection& reader) { return SelectRevisions(reader, limit); });
}

absl::StatusOr<std::vector<std::pair<int64_t, SubmapMove>>> SqlStore::ListMoves(int64_t from,
                                                                                int64_t to) const {
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

absl::StatusOr<EventPage> SqlStore::ListEvents(const EventQuery& query) const {
  return AtOneMoment<EventPage>([&](Connection& reader) { return SelectEvents(reader, query); });
}

absl::Status SqlStore::PutFeatures(const FeatureBlob& blob) {
  if (large_values() == nullptr) {
    return writer_.Run([&](Connection& database) { return PutFeatureRow(database, blob); });
  }
  absl::StatusOr<std::string> row = ToRow(blob.data);
  if (!row.ok()) return row.status();
  const FeatureBlob in_row = {blob.submap, blob.kind, *std::move(row)};
  return writer_.Run([&](Connection& database) { return PutFeatureRow(database, in_row); });
}

absl::StatusOr<std::string> SqlStore::GetFeatures(const SubmapId& submap,
                                                  const std::string& kind) const {
  absl::StatusOr<std::string> row = AtOneMoment<std::string>(
      [&](Connection& reader) { return FindFeatures(reader, submap, kind); });
  if (!row.ok()) return row;
  return FromRow(*std::move(row));
}

}  // namespace isthmus::storage
