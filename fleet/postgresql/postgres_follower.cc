#include "fleet/postgresql/postgres_follower.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>

#include <algorithm>
#include <utility>

#include "fleet/postgresql/limits.h"
#include "fleet/postgresql/migrations.h"
#include "storage/sql/rows.h"

namespace isthmus::storage {
namespace {

// Tables that are read whole.
constexpr const char* kTables[] = {"sessions", "matches", "verdicts", "loops", "anchors", "datum"};

// A text for each table that is another one once a row came, changed or went: a row that is written
// carries a transaction of a higher number than all before.
std::string TellTables() {
  std::string columns;
  for (const char* table : kTables) {
    absl::StrAppend(&columns, columns.empty() ? "" : ", ",
                    "(SELECT count(*) || ' ' || coalesce(sum(xmin::text::bigint), 0) FROM ", table,
                    ")");
  }
  return absl::StrCat("SELECT ", columns);
}

std::string ArrayText(const std::vector<int64_t>& numbers) {
  return absl::StrCat("{", absl::StrJoin(numbers, ","), "}");
}

template <typename T, typename Select>
absl::Status ReadInto(Connection& database, const Select& select, std::optional<T>* into) {
  absl::StatusOr<T> read = select(database);
  if (!read.ok()) return read.status();
  *into = *std::move(read);
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<StoreDelta> PostgresFollower::Next() {
  StoreDelta delta;
  const Transaction snapshot(*database_, Transaction::Kind::kRead);
  if (!snapshot.status().ok()) return snapshot.status();
  const absl::StatusOr<Mark> mark = ReadMark(&delta.owner);
  if (!mark.ok()) return mark.status();
  const bool is_first = known_.revision < 0;
  if (!is_first && *mark == known_.mark && !known_.has_more) return delta;
  absl::Status status = CheckMigrated(*database_, database_->target().schema);
  if (status.ok() && !is_first) status = CheckGoesOn(*mark);
  Known known = known_;
  known.mark = *mark;
  if (status.ok()) status = ReadDelta(&known, &delta);
  if (!status.ok()) return status;
  known_ = std::move(known);
  return delta;
}

absl::StatusOr<PostgresFollower::Mark> PostgresFollower::ReadMark(std::string* owner) {
  Statement row = database_->Prepare(
      "SELECT epoch, since_ns, last_commit, holder FROM owners WHERE is_current");
  const absl::StatusOr<bool> found = row.Step();
  if (!found.ok()) return found.status();
  if (!*found) return Mark();
  *owner = row.Text(3);
  return Mark{row.Int(0), row.Int(1), row.Int(2)};
}

absl::Status PostgresFollower::CheckGoesOn(const Mark& mark) {
  const Mark& before = known_.mark;
  if (before == Mark()) return absl::OkStatus();
  Statement row =
      database_->Prepare("SELECT last_commit FROM owners WHERE epoch = ? AND since_ns = ?");
  const absl::StatusOr<bool> found = row.Bind(before.epoch).Bind(before.since_ns).Step();
  if (!found.ok()) return found.status();
  if (*found && row.Int(0) >= before.commit) return absl::OkStatus();
  const bool may_catch_up = mark.epoch <= before.epoch;
  return absl::UnavailableError(absl::StrCat(
      "PostgreSQL has less than was read from it already",
      may_catch_up ? " (it follows another one and lags behind, or was restored from a backup)"
                   : ": it was restored from a backup, or went on without its last commits; "
                     "restart this server to follow from there"));
}

absl::Status PostgresFollower::ReadDelta(Known* known, StoreDelta* delta) {
  absl::Status status = ReadTables(known, delta);
  if (status.ok()) status = ReadSubmaps(known, delta);
  if (status.ok()) status = ReadTrajectories(known, delta);
  if (status.ok()) status = ReadRevision(known, delta);
  if (!status.ok()) return status;
  const auto event = database_->ReadNumber("SELECT coalesce(max(number), 0) FROM events");
  if (!event.ok()) return event.status();
  delta->has_events = known->event != *event;
  known->event = *event;
  return absl::OkStatus();
}

absl::Status PostgresFollower::ReadTables(Known* known, StoreDelta* delta) {
  std::map<std::string, bool> is_new;
  {
    Statement row = database_->Prepare(TellTables());
    if (absl::Status status = row.Step().status(); !status.ok()) return status;
    int column = 0;
    for (const char* table : kTables) {
      std::string& text = known->tables[table];
      is_new[table] = text != row.Text(column);
      text = row.Text(column++);
    }
  }
  absl::Status status;
  const auto read = [&](const char* table, const auto& select, auto* into) {
    if (status.ok() && is_new[table]) status = ReadInto(*database_, select, into);
  };
  read("sessions", SelectSessions, &delta->sessions);
  read("matches", SelectMatches, &delta->matches);
  read("verdicts", SelectManualDecisions, &delta->manual_decisions);
  read("loops", SelectLoops, &delta->loops);
  read("anchors", SelectAnchors, &delta->anchors);
  read("datum", SelectDatum, &delta->datum);
  return status;
}

absl::Status PostgresFollower::ReadSubmaps(Known* known, StoreDelta* delta) {
  auto added = SelectSubmapsBehind(*database_, known->last_submap);
  if (!added.ok()) return added.status();
  int64_t count = 0;
  {
    Statement row = database_->Prepare("SELECT count(*), coalesce(max(key), 0) FROM submaps");
    if (absl::Status status = row.Step().status(); !status.ok()) return status;
    count = row.Int(0);
    // The last that was known may be among those that are gone.
    known->last_submap = std::max(known->last_submap, row.Int(1));
  }
  if (known->submaps + static_cast<int64_t>(added->size()) != count) {
    auto ids = SelectSubmapIds(*database_);
    if (!ids.ok()) return ids.status();
    delta->remaining.emplace(ids->begin(), ids->end());
  }
  known->submaps = count;
  delta->submaps = *std::move(added);
  return absl::OkStatus();
}

// Drops the trails of sessions that are gone; one that ended is read once more.
absl::Status PostgresFollower::ReadTrails(Known* known) {
  std::map<int64_t, Trail> trails;
  Statement row = database_->Prepare("SELECT key, id, state FROM sessions");
  while (true) {
    const absl::StatusOr<bool> found = row.Step();
    if (!found.ok()) return found.status();
    if (!*found) break;
    const auto before = known->trails.find(row.Int(0));
    Trail& trail = trails[row.Int(0)];
    trail = before == known->trails.end() ? Trail{SessionId(row.Text(1))} : before->second;
    trail.is_active = row.Int(2) == 0;
  }
  known->trails = std::move(trails);
  return absl::OkStatus();
}

absl::Status PostgresFollower::ReadTrajectories(Known* known, StoreDelta* delta) {
  if (delta->sessions) {
    if (absl::Status status = ReadTrails(known); !status.ok()) return status;
  }
  std::vector<int64_t> keys, last;
  for (const auto& [key, trail] : known->trails) {
    if (trail.is_read) continue;
    keys.push_back(key);
    last.push_back(trail.last_sequence);
  }
  auto rows = database_
                  ->Prepare(
                      "SELECT t.sequence, t.stamp_ns, t.submap_index, t.T_odom_sensor, k.key FROM "
                      "unnest(?::text::bigint[], ?::text::bigint[]) AS k (key, last) JOIN "
                      "trajectory t ON t.session = k.key AND t.sequence > k.last "
                      "ORDER BY k.key, t.sequence LIMIT ?")
                  .Bind(ArrayText(keys))
                  .Bind(ArrayText(last))
                  .Bind(kEntriesAtOnce)
                  .ReadAll([](const Statement& row) {
                    return std::pair(row.Int(4), ReadTrajectoryEntry(row));
                  });
  if (!rows.ok()) return rows.status();
  for (const auto& [key, entry] : *rows) {
    Trail& trail = known->trails[key];
    delta->trajectory.emplace_back(trail.session, entry);
    trail.last_sequence = static_cast<int64_t>(entry.sequence);
  }
  known->has_more = static_cast<int64_t>(rows->size()) == kEntriesAtOnce;
  if (known->has_more) return absl::OkStatus();
  for (auto& [key, trail] : known->trails) trail.is_read = !trail.is_active;
  return absl::OkStatus();
}

absl::Status PostgresFollower::ReadRevision(Known* known, StoreDelta* delta) {
  const absl::StatusOr<int64_t> latest = LatestRevisionNumber(*database_);
  if (!latest.ok()) return latest.status();
  if (std::exchange(known->revision, *latest) == *latest) return absl::OkStatus();
  return ReadInto(*database_, SelectLatestRevision, &delta->revision);
}

}  // namespace isthmus::storage
