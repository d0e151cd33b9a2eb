#include <algorithm>

#include "storage/records/pose_codec.h"
#include "storage/revision_log.h"
#include "storage/sql/rows.h"

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
          "WINDOW newer AS (ORDER BY revision DESC)) AS counted WHERE nth > ? OR (nth > 1 AND "
          "moves > ?))")
      .Bind(kRevisionsKept)
      .Bind(kMovesKept)
      .Run();
}

absl::StatusOr<std::vector<Placement>> SelectPlacements(Connection& database, int64_t revision) {
  Statement rows = database.Prepare(
      "SELECT session, component, reference, T_map_odom FROM placements WHERE revision = ? "
      "ORDER BY session");
  auto placements = rows.Bind(revision).ReadAll([](const Statement& row) {
    return Placement{SessionId(row.Text(0)), row.Uint32(1), SessionId(row.Text(2)),
                     UnpackPose(row.Text(3))};
  });
  if (!placements.ok()) return placements;
  for (Placement& placement : *placements) {
    auto submaps = SelectPlacedSubmaps(database, placement.session);
    if (!submaps.ok()) return submaps.status();
    placement.submaps = *std::move(submaps);
  }
  return placements;
}

// The matches and loop closures that it came of.
absl::Status SelectCauses(Connection& database, RevisionInfo& info) {
  Statement pairs =
      database.Prepare("SELECT a, b FROM revision_matches WHERE revision = ? ORDER BY position");
  auto matches = pairs.Bind(info.revision).ReadAll([](const Statement& row) {
    return std::pair(SessionId(row.Text(0)), SessionId(row.Text(1)));
  });
  if (!matches.ok()) return matches.status();
  info.matches = *std::move(matches);
  Statement ids =
      database.Prepare("SELECT loop FROM revision_loops WHERE revision = ? ORDER BY position");
  auto loops = ids.Bind(info.revision).ReadAll([](const Statement& row) { return row.Uint(0); });
  if (!loops.ok()) return loops.status();
  info.loops = *std::move(loops);
  return absl::OkStatus();
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
  return database.ReadNumber("SELECT coalesce(max(revision), 0) FROM revisions");
}

absl::StatusOr<int64_t> OldestComparableRevision(Connection& database) {
  // The effects of a revision of an older schema are not known; see migration 0005.
  return database.ReadNumber(
      "SELECT coalesce(max(revision) FILTER (WHERE added IS NULL), min(revision) - 1, 0) "
      "FROM revisions");
}

absl::StatusOr<std::vector<RevisionInfo>> SelectRevisions(Connection& database, int limit) {
  Statement rows = database.Prepare(std::string("SELECT ") + kRevisionColumns +
                                    " FROM revisions ORDER BY revision DESC LIMIT ?");
  auto infos = rows.Bind(std::max(limit, 0)).ReadAll([](const Statement& row) {
    RevisionInfo info;
    info.revision = row.Int(0);
    info.stamp_ns = row.Int(1);
    info.cause = row.Text(2);
    info.added = row.Uint32(3);
    info.moved = row.Uint32(4);
    info.removed = row.Uint32(5);
    info.largest_move_m = row.Real(6);
    return info;
  });
  if (!infos.ok()) return infos;
  for (RevisionInfo& info : *infos) {
    if (auto status = SelectCauses(database, info); !status.ok()) return status;
  }
  return infos;
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
