#include "client/report/server_tables.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <absl/time/time.h>

#include <algorithm>
#include <utility>

#include "client/report/limits.h"

namespace isthmus::report {
namespace {

std::string TimeText(int64_t unix_ns) {
  return absl::FormatTime("%Y-%m-%d %H:%M:%S", absl::FromUnixNanos(unix_ns), absl::UTCTimeZone());
}

// Numbers that were not computed are negative.
std::string NumberOr(double value, int decimals) {
  return value < 0 ? std::string() : absl::StrFormat("%.*f", decimals, value);
}

// Empty for 0: the server counts such a figure since it started, and later segments have none.
std::string AboveZero(double value) { return value > 0 ? absl::StrFormat("%.1f", value) : ""; }

std::string PercentOr(double share) { return NumberOr(100 * share, 1); }

Table Cut(Table table) {
  if (table.rows.size() <= kMostRows) return table;
  table.note = absl::StrFormat("%d more rows are left out.", table.rows.size() - kMostRows);
  table.rows.resize(kMostRows);
  return table;
}

double SumMs(const std::vector<StageTime>& stages) {
  double ms = 0;
  for (const StageTime& stage : stages) ms += stage.ms;
  return ms;
}

std::string TrackingOf(const SessionStatus& session) {
  if (session.record.segment > 1) {
    return absl::StrCat("segment ", session.record.segment, " of ",
                        session.record.first_segment.value());
  }
  if (session.lost_since_ns != 0) return "LOST";
  return ToString(session.tracking);
}

}  // namespace

Table RobotsTable(const ServerState& state) {
  Table table{"",
              {"robot", "session", "sensor", "state", "tracking", "ok", "degenerate", "lost",
               "rejected", "way m", "ms per scan", "submaps", "map"},
              {},
              5};
  for (const SessionStatus& session : state.sessions) {
    const bool is_first = session.record.segment <= 1;  // Has the counts of all segments.
    const auto count = [&](uint64_t n) { return is_first ? absl::StrCat(n) : std::string(); };
    table.rows.push_back(
        {session.record.robot.value(), session.record.id.value(), session.record.sensor,
         session.record.state == SessionState::kFinished ? "finished" : "active",
         TrackingOf(session), count(session.scans.ok), count(session.scans.degenerate),
         count(session.scans.lost), count(session.scans.rejected), AboveZero(session.travelled_m),
         AboveZero(session.odometry_ms_mean), absl::StrCat(session.submap_count),
         session.component ? absl::StrCat(*session.component) : "not placed"});
  }
  return Cut(std::move(table));
}

Table MatchesTable(const ServerState& state) {
  Table table{"",
              {"sessions", "state", "why", "in detail", "probability", "overlap %", "residual m",
               "contradicted %", "shared m2", "ms"},
              {},
              4};
  std::vector<const MatchEdge*> edges;
  for (const MatchEdge& edge : state.graph.matches) edges.push_back(&edge);
  std::stable_sort(edges.begin(), edges.end(), [](const MatchEdge* a, const MatchEdge* b) {
    const auto rank = [](const MatchEdge& edge) {
      return std::make_tuple(edge.in_tree, edge.match.state == MatchState::kAccepted,
                             edge.match.confidence);
    };
    return rank(*a) > rank(*b);
  });
  for (const MatchEdge* edge : edges) {
    const Match& m = edge->match;
    table.rows.push_back({absl::StrCat(m.a.value(), " ~ ", m.b.value()),
                          absl::StrCat(ToString(m.state), edge->in_tree ? ", carries the map" : ""),
                          ToString(m.reason), m.detail, NumberOr(m.confidence, 2),
                          PercentOr(m.overlap), NumberOr(m.residual_m, 3), PercentOr(m.free_space),
                          NumberOr(m.shared_area_m2, 0), absl::StrFormat("%.0f", SumMs(m.stages))});
  }
  return Cut(std::move(table));
}

Table DecisionsTable(const ServerState& state) {
  Table table{"Decided by hand", {"what", "decision", "note", "time (UTC)"}, {}, 4};
  for (const MatchEdge& edge : state.graph.matches) {
    if (!edge.manual_decision) continue;
    table.rows.push_back({absl::StrCat(edge.match.a.value(), " ~ ", edge.match.b.value()),
                          ToString(edge.manual_decision->kind), edge.manual_decision->note,
                          TimeText(edge.manual_decision->given_ns)});
  }
  for (const Loop& loop : state.loops) {
    if (!loop.loop.rejected) continue;
    table.rows.push_back(
        {absl::StrCat("loop closure ", loop.loop.id), "REJECT", loop.loop.note, ""});
  }
  return Cut(std::move(table));
}

Table LoopsTable(const ServerState& state) {
  Table table{"",
              {"session", "submaps", "state", "in detail", "id", "probability", "overlap %",
               "residual m", "edges used"},
              {},
              4};
  for (const Loop& record : state.loops) {
    const LoopClosure& loop = record.loop;
    table.rows.push_back({loop.session.value(), absl::StrCat(loop.submap_a, " ~ ", loop.submap_b),
                          loop.rejected            ? "REJECTED"
                          : record.edges_used == 0 ? "SET ASIDE"
                                                   : "USED",
                          loop.detail, absl::StrCat(loop.id), NumberOr(loop.confidence, 2),
                          PercentOr(loop.overlap), NumberOr(loop.residual_m, 3),
                          absl::StrCat(record.edges_used, " of ", record.edge_count)});
  }
  return Cut(std::move(table));
}

Table RevisionsTable(const ServerState& state) {
  Table table{"",
              {"revision", "time (UTC)", "cause", "added", "moved", "removed", "largest move m"},
              {},
              3};
  for (const RevisionInfo& revision : state.revisions) {
    table.rows.push_back({absl::StrCat(revision.revision), TimeText(revision.stamp_ns),
                          revision.cause, absl::StrCat(revision.added),
                          absl::StrCat(revision.moved), absl::StrCat(revision.removed),
                          absl::StrFormat("%.3f", revision.largest_move_m)});
  }
  return table;
}

Table TimesTable(const ServerState& state) {
  const MapInfo& info = state.info;
  Table table{"", {"what", "the last", "the longest", "how many"}, {}};
  const auto ms = [](double value) { return absl::StrFormat("%.1f ms", value); };
  table.rows.push_back({"composing the map", ms(info.composition_ms), ms(info.composition_max_ms),
                        absl::StrCat(info.compositions)});
  table.rows.push_back(
      {"placing the submaps", ms(info.placement_ms), "", absl::StrCat(info.placements)});
  table.rows.push_back(
      {"matching maps (a round)", ms(info.estimation_ms), "", absl::StrCat(info.estimations)});
  double longest = 0;
  for (const MatchEdge& edge : state.graph.matches) {
    longest = std::max(longest, SumMs(edge.match.stages));
  }
  table.rows.push_back(
      {"matching one pair", "", ms(longest), absl::StrCat(state.graph.matches.size())});
  table.note = "Wall times since the server started. Odometry per scan is in the table of robots.";
  return table;
}

}  // namespace isthmus::report
