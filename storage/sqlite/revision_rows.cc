#include "storage/records/pose_codec.h"
#include "storage/revision_log.h"
#include "storage/sqlite/rows.h"

namespace isthmus::storage {
namespace {

constexpr char kRevisionColumns[] =
    "revision, stamp_ns, cause, coalesce(added, 0), moved, removed, largest_move_m";

absl::Status AddInfo(Connection& database, const RevisionInfo& info) {
  absl::Status status =
      database
          .Prepare(
              "INSERT INTO revisions (revision, stamp_ns, cause, added, moved, removed, "
              "largest_move_m) VALUES (?, ?, ?, ?, ?, ?, ?)")
          .Bind(info.revision)
          .Bind(info.stamp_ns)
          .Bind(info.cause)
          .Bind(info.added)
          .Bind(info.moved)
          .Bind(info.removed)
          .Bind(info.largest_move_m)
          .Run();
  Statement match = database.Prepare(
      "INSERT INTO revision_matches (revision, position, a, b) VALUES (?, ?, ?, ?)");
  int position = 0;
  for (const auto& [a, b] : info.matches) {
    match.Bind(info.revision).Bind(position++).Bind(a.value()).Bind(b.value());
    if (status.ok()) status = match.Run();
  }
  Statement loop =
      database.Prepare("INSERT INTO revision_loops (revision, position, loop) VALUES (?, ?, ?)");
  position = 0;
  for (const uint64_t id : info.loops) {
    loop.Bind(info.revision).Bind(position++).Bind(id);
    if (status.ok()) status = loop.Run();
  }
  return status;
}

absl::Status ReplacePlacements(Connection& database, const MapRevision& revision) {
  if (auto status = database.Prepare("DELETE FROM placements").Run(); !status.ok()) return status;
  Statement insert = database.Prepare(
      "INSERT INTO placements (revision, session, component, reference, T_map_odom) "
      "VALUES (?, ?, ?, ?, ?)");
  for (const Placement& placement : revision.placements) {
    const absl::Status status = insert.Bind(revision.revision)
                                    .Bind(placement.session.value())
                                    .Bind(placement.component)
                                    .Bind(placement.reference.value())
                                    .BindBlob(PackPose(placement.T_map_odom))
                                    .Run();
    if (!status.ok()) return status;
  }
  return absl::OkStatus();
}

// Revisions go as a whole, the oldest first, while they or their moves are too many.
absl::Status Prune(Connection& database) {
  return database
      .Prepare(
          "DELETE FROM revisions WHERE revision <= (SELECT max(revision) FROM ("
          "SELECT revision, row_number() OVER newer AS nth, "
          "sum(coalesce(added, 0) + moved + removed) OVER newer AS moves FROM revisions "
          "WINDOW newer AS (ORDER BY revision DESC)) WHERE nth > ? OR (nth > 1 AND moves > ?))")
      .Bind(kRevisionsKept)
      .Bind(kMovesKept)
      .Run();
}

absl::StatusOr<std::vector<Placement>> SelectPlacements(Connection& database, int64_t revision) {
  std::vector<Placement> placements;
  Statement row = database.Prepare(
      "SELECT session, component, reference, T_map_odom FROM placements WHERE revision = ? "
      "ORDER BY session");
  row.Bind(revision);
  while (true) {
    absl::StatusOr<bool> has_row = row.Step();
    if (!has_row.ok()) return has_row.status();
    if (!*has_row) return placements;
    Placement placement;
    placement.session = SessionId(row.Text(0));
    placement.component = static_cast<uint32_t>(row.Int(1));
    placement.reference = SessionId(row.Text(2));
    placement.T_map_odom = UnpackPose(row.Text(3));
    auto submaps = SelectPlacedSubmaps(database, placement.session);
    if (!submaps.ok()) return submaps.status();
    placement.submaps = *std::move(submaps);
    placements.push_back(std::move(placement));
  }
}

absl::Status SelectMatchesOf(Connection& database, RevisionInfo& info) {
  Statement row =
      database.Prepare("SELECT a, b FROM revision_matches WHERE revision = ? ORDER BY position");
  row.Bind(info.revision);
  while (true) {
    absl::StatusOr<bool> has_row = row.Step();
    if (!has_row.ok() || !*has_row) return has_row.status();
    info.matches.emplace_back(SessionId(row.Text(0)), SessionId(row.Text(1)));
  }
}

absl::Status SelectLoopsOf(Connection& database, RevisionInfo& info) {
  Statement row =
      database.Prepare("SELECT loop FROM revision_loops WHERE revision = ? ORDER BY position");
  row.Bind(info.revision);
  while (true) {
    absl::StatusOr<bool> has_row = row.Step();
    if (!has_row.ok() || !*has_row) return has_row.status();
    info.loops.push_back(row.Uint(0));
  }
}

}  // namespace

absl::Status AddRevision(Connection& database, const MapRevision& revision,
                         const std::vector<SubmapMove>& moves) {
  absl::Status status = AddInfo(database, Describe(revision, moves));
  if (status.ok()) status = ReplacePlacements(database, revision);
  if (status.ok()) status = AddMoves(database, revision.revision, moves);
  if (status.ok()) status = Prune(database);
  return status;
}

absl::StatusOr<int64_t> LatestRevisionNumber(Connection& database) {
  Statement row = database.Prepare("SELECT coalesce(max(revision), 0) FROM revisions");
  absl::StatusOr<bool> found = row.Step();
  if (!found.ok()) return found.status();
  return row.Int(0);
}

absl::StatusOr<int64_t> OldestComparableRevision(Connection& database) {
  // The effects of a revision of an older schema are not known; see migration 0005.
  Statement row = database.Prepare(
      "SELECT coalesce(max(revision) FILTER (WHERE added IS NULL), min(revision) - 1, 0) "
      "FROM revisions");
  absl::StatusOr<bool> found = row.Step();
  if (!found.ok()) return found.status();
  return row.Int(0);
}

absl::StatusOr<std::vector<RevisionInfo>> SelectRevisions(Connection& database, int limit) {
  std::vector<RevisionInfo> infos;
  Statement row = database.Prepare(std::string("SELECT ") + kRevisionColumns +
                                   " FROM revisions ORDER BY revision DESC LIMIT max(?, 0)");
  row.Bind(limit);
  while (true) {
    absl::StatusOr<bool> has_row = row.Step();
    if (!has_row.ok()) return has_row.status();
    if (!*has_row) return infos;
    RevisionInfo info;
    info.revision = row.Int(0);
    info.stamp_ns = row.Int(1);
    info.cause = row.Text(2);
    info.added = static_cast<uint32_t>(row.Int(3));
    info.moved = static_cast<uint32_t>(row.Int(4));
    info.removed = static_cast<uint32_t>(row.Int(5));
    info.largest_move_m = row.Real(6);
    if (auto status = SelectMatchesOf(database, info); !status.ok()) return status;
    if (auto status = SelectLoopsOf(database, info); !status.ok()) return status;
    infos.push_back(std::move(info));
  }
}

absl::StatusOr<MapRevision> SelectLatestRevision(Connection& database) {
  auto infos = SelectRevisions(database, 1);
  if (!infos.ok()) return infos.status();
  if (infos->empty()) return MapRevision();
  const RevisionInfo& info = infos->front();
  auto placements = SelectPlacements(database, info.revision);
  if (!placements.ok()) return placements.status();
  return MapRevision{.revision = info.revision,
                     .stamp_ns = info.stamp_ns,
                     .cause = info.cause,
                     .matches = info.matches,
                     .loops = info.loops,
                     .placements = *std::move(placements)};
}

}  // namespace isthmus::storage
