#include <set>

#include "storage/records/edge_codec.h"
#include "storage/records/pose_codec.h"
#include "storage/sql/rows.h"

namespace isthmus::storage {
namespace {

// False where the edges are damaged.
bool ReadLoop(const Statement& row, LoopClosure& loop) {
  loop.id = row.Uint(0);
  loop.session = SessionId(row.Text(1));
  loop.submap_a = row.Uint32(2);
  loop.submap_b = row.Uint32(3);
  loop.T_a_b = UnpackPose(row.Text(4));
  loop.confidence = row.Real(5);
  loop.overlap = row.Real(6);
  loop.residual_m = row.Real(7);
  loop.free_space = row.Real(8);
  loop.comparisons = row.Int(9);
  loop.source = ParseGuessSource(row.Text(10));
  loop.detail = row.Text(11);
  loop.computed_ns = row.Int(12);
  loop.rejected = row.Int(13) != 0;
  loop.note = row.Text(14);
  return DecodeEdges(row.Text(15), loop.edges).ok();
}

// The ids of the session's loop closures none of whose edges, if any can be read, has both its
// submaps.
absl::StatusOr<std::vector<int64_t>> SelectLost(Connection& database, int64_t session_key) {
  Statement indices = database.Prepare("SELECT submap_index FROM submaps WHERE session = ?");
  const auto listed =
      indices.Bind(session_key).ReadAll([](const Statement& row) { return row.Uint32(0); });
  if (!listed.ok()) return listed.status();
  const std::set<uint32_t> submaps(listed->begin(), listed->end());
  std::vector<int64_t> lost;
  Statement row = database.Prepare("SELECT id, edges FROM loops WHERE session = ?");
  row.Bind(session_key);
  while (true) {
    absl::StatusOr<bool> has_row = row.Step();
    if (!has_row.ok()) return has_row.status();
    if (!*has_row) return lost;
    std::vector<SubmapEdge> edges;
    if (!DecodeEdges(row.Text(1), edges).ok()) edges.clear();
    bool holds = false;
    for (const SubmapEdge& edge : edges) {
      holds = holds || (submaps.contains(edge.submap_a) && submaps.contains(edge.submap_b));
    }
    if (!holds) lost.push_back(row.Int(0));
  }
}

}  // namespace

absl::Status PutLoop(Connection& database, const LoopClosure& loop) {
  absl::StatusOr<std::optional<int64_t>> session = FindSessionKey(database, loop.session);
  if (!session.ok()) return session.status();
  if (!*session) return absl::InternalError("a loop closure of an unchecked session");
  return database
      .Prepare(
          "INSERT INTO loops (id, session, submap_a, submap_b, T_a_b, confidence, "
          "overlap, residual_m, free_space, comparisons, source, detail, computed_ns, rejected, "
          "note, edges) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?) ON CONFLICT (id) "
          "DO "
          "UPDATE SET session = excluded.session, submap_a = excluded.submap_a, "
          "submap_b = excluded.submap_b, T_a_b = excluded.T_a_b, "
          "confidence = excluded.confidence, overlap = excluded.overlap, "
          "residual_m = excluded.residual_m, free_space = excluded.free_space, "
          "comparisons = excluded.comparisons, source = excluded.source, "
          "detail = excluded.detail, computed_ns = excluded.computed_ns, "
          "rejected = excluded.rejected, note = excluded.note, edges = excluded.edges")
      .Bind(loop.id)
      .Bind(**session)
      .Bind(loop.submap_a)
      .Bind(loop.submap_b)
      .BindBlob(PackPose(loop.T_a_b))
      .Bind(loop.confidence)
      .Bind(loop.overlap)
      .Bind(loop.residual_m)
      .Bind(loop.free_space)
      .Bind(loop.comparisons)
      .Bind(std::string(ToString(loop.source)))
      .Bind(loop.detail)
      .Bind(loop.computed_ns)
      .Bind(loop.rejected ? 1 : 0)
      .Bind(loop.note)
      .BindBlob(EncodeEdges(loop.edges))
      .Run();
}

absl::StatusOr<std::vector<LoopClosure>> SelectLoops(Connection& database) {
  std::vector<LoopClosure> loops;
  Statement row = database.Prepare(
      "SELECT l.id, e.id, submap_a, submap_b, T_a_b, confidence, overlap, residual_m, free_space, "
      "comparisons, source, detail, computed_ns, rejected, l.note, edges "
      "FROM loops l JOIN sessions e ON e.key = l.session ORDER BY l.id");
  while (true) {
    absl::StatusOr<bool> has_row = row.Step();
    if (!has_row.ok()) return has_row.status();
    if (!*has_row) return loops;
    LoopClosure loop;
    if (ReadLoop(row, loop)) loops.push_back(std::move(loop));
  }
}

absl::Status RemoveLostLoops(Connection& database, int64_t session_key) {
  absl::StatusOr<std::vector<int64_t>> lost = SelectLost(database, session_key);
  if (!lost.ok()) return lost.status();
  Statement remove = database.Prepare("DELETE FROM loops WHERE id = ?");
  for (const int64_t id : *lost) {
    if (absl::Status status = remove.Bind(id).Run(); !status.ok()) return status;
  }
  return absl::OkStatus();
}

}  // namespace isthmus::storage
