#include "storage/sql/rows.h"

namespace isthmus::storage {

absl::Status PutMatchingProgress(Connection& database, const MatchingProgress& progress) {
  absl::StatusOr<std::optional<int64_t>> session = FindSessionKey(database, progress.session);
  if (!session.ok()) return session.status();
  return database
      .Prepare(
          "INSERT INTO matching_progress (session, next_for_loops, next_at_choice, max_pairs, "
          "max_searched, max_joined) VALUES (?, ?, ?, ?, ?, ?) ON CONFLICT (session) DO UPDATE SET "
          "next_for_loops = excluded.next_for_loops, next_at_choice = excluded.next_at_choice, "
          "max_pairs = excluded.max_pairs, max_searched = excluded.max_searched, "
          "max_joined = excluded.max_joined")
      .Bind(session->value())
      .Bind(progress.next_for_loops)
      .Bind(progress.next_at_choice)
      .Bind(progress.max_pairs)
      .Bind(progress.max_searched)
      .Bind(progress.max_joined)
      .Run();
}

absl::StatusOr<std::vector<MatchingProgress>> SelectMatchingProgress(Connection& database) {
  return database
      .Prepare(
          "SELECT s.id, p.next_for_loops, p.next_at_choice, p.max_pairs, p.max_searched, "
          "p.max_joined FROM matching_progress p JOIN sessions s ON s.key = p.session "
          "ORDER BY s.id")
      .ReadAll([](const Statement& row) {
        return MatchingProgress{SessionId(row.Text(0)),
                                row.Uint32(1),
                                row.Uint32(2),
                                row.Uint(3),
                                row.Uint(4),
                                row.Uint(5)};
      });
}

}  // namespace isthmus::storage
