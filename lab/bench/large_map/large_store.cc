#include "lab/bench/large_map/large_store.h"

#include <absl/strings/str_format.h>

#include <cstdio>
#include <filesystem>
#include <memory>
#include <utility>
#include <vector>

#include "storage/sqlite/sqlite_store.h"

namespace isthmus::bench {
namespace {

constexpr int64_t kBeginNs = 1'700'000'000'000'000'000;
constexpr int64_t kKeyframeNs = 100'000'000;

SessionRecord MakeSession(int number, int robots) {
  SessionRecord session;
  session.robot = RobotId(absl::StrFormat("robot_%c", 'a' + number % robots));
  session.id = SessionId(absl::StrFormat("%s-%d", session.robot.value(), number / robots + 1));
  session.sensor = "hdl64";
  session.state = SessionState::kFinished;
  session.created_ns = kBeginNs + number * int64_t{1'000'000'000'000};
  session.finished_ns = session.created_ns + 1;
  return session;
}

// Gives a submap its name and times, and its scans their poses.
void Name(const SessionRecord& session, uint32_t index, Submap* submap,
          storage::WriteBatch* batch) {
  submap->id = {session.id, index};
  submap->robot = session.robot;
  submap->drift_covariance = Matrix6d::Identity() * 1e-4;
  const uint64_t per_submap = submap->keyframes.size();
  submap->first_sequence = index * per_submap + 1;
  for (uint64_t k = 0; k < per_submap; ++k) {
    Keyframe& keyframe = submap->keyframes[k];
    keyframe.sequence = submap->first_sequence + k;
    keyframe.stamp_ns = session.created_ns + static_cast<int64_t>(keyframe.sequence) * kKeyframeNs;
    batch->trajectory.push_back({session.id,
                                 {keyframe.sequence, keyframe.stamp_ns,
                                  submap->T_odom_submap * keyframe.T_submap_sensor, index}});
  }
  submap->last_sequence = submap->first_sequence + per_submap - 1;
  submap->first_stamp_ns = submap->keyframes.front().stamp_ns;
  submap->last_stamp_ns = submap->keyframes.back().stamp_ns;
}

// The pair was compared without a result; that of the first session is then given by hand.
void Compare(const std::vector<std::pair<SessionId, uint32_t>>& sessions, size_t one, size_t other,
             storage::WriteBatch* batch) {
  const auto [a, b] = std::minmax(sessions[one], sessions[other]);
  Match match;
  match.a = a.first;
  match.b = b.first;
  match.state = MatchState::kRejected;
  match.reason = MatchReason::kFreeSpace;
  match.detail = "generated: not compared";
  match.submaps_a = a.second;
  match.submaps_b = b.second;
  match.computed_ns = kBeginNs * 2;
  batch->matches.push_back(match);
  if (one != 0) return;
  ManualDecision manual_decision;
  manual_decision.a = match.a;
  manual_decision.b = match.b;
  manual_decision.kind = ManualDecisionKind::kSet;
  manual_decision.note = "generated";
  manual_decision.given_ns = kBeginNs;
  batch->manual_decisions.push_back(manual_decision);
}

// A submap of what a robot sees at a place of its path. A later visit sees what is stored of the
// first: points are dear to draw.
absl::StatusOr<std::shared_ptr<Submap>> MakeSubmapAt(const LargeStoreOptions& options,
                                                     const City& city, int place, std::mt19937* rng,
                                                     const storage::MapStore& store) {
  const int per_session = options.submaps_per_session;
  const int places = static_cast<int>(city.path_length_m() / city.submap_length_m());
  if (place < places) {
    const double lane_m = -3 + 1.5 * (place / per_session % 5);
    return std::make_shared<Submap>(city.Drive(place * city.submap_length_m(), lane_m, rng));
  }
  const int first = place % places;
  const SessionId session = MakeSession(first / per_session, options.robots).id;
  auto seen = store.GetSubmap({session, static_cast<uint32_t>(first % per_session)});
  if (!seen.ok()) return seen.status();
  return std::make_shared<Submap>(**seen);
}

absl::StatusOr<uint32_t> AddSession(const LargeStoreOptions& options, const City& city, int number,
                                    const std::string& folder, storage::MapStore* store) {
  std::mt19937 rng(options.seed + static_cast<unsigned>(number));
  const SessionRecord session = MakeSession(number, options.robots);
  storage::WriteBatch first;
  first.sessions.push_back(session);
  if (absl::Status status = store->Write(first); !status.ok()) return status;
  uint32_t index = 0;
  while (index < static_cast<uint32_t>(options.submaps_per_session) &&
         BytesOnDisk(folder) < options.bytes) {
    const int place = number * options.submaps_per_session + static_cast<int>(index);
    auto submap = MakeSubmapAt(options, city, place, &rng, *store);
    if (!submap.ok()) return submap.status();
    storage::WriteBatch batch;
    Name(session, index++, submap->get(), &batch);
    batch.submaps.push_back(*std::move(submap));
    if (absl::Status status = store->Write(batch); !status.ok()) return status;
  }
  return index;
}

}  // namespace

double BytesOnDisk(const std::string& folder) {
  double bytes = 0;
  for (const auto& file : std::filesystem::recursive_directory_iterator(folder)) {
    if (file.is_regular_file()) bytes += static_cast<double>(file.file_size());
  }
  return bytes;
}

absl::Status FillStore(const LargeStoreOptions& options, const std::string& folder) {
  auto store = storage::OpenSqliteStore(folder, {.sync_every_commit = false});
  if (!store.ok()) return store.status();
  const City city(options.city);
  std::vector<std::pair<SessionId, uint32_t>> sessions;  // And how many submaps each has.
  while (BytesOnDisk(folder) < options.bytes) {
    const int number = static_cast<int>(sessions.size());
    const auto submaps = AddSession(options, city, number, folder, store->get());
    if (!submaps.ok()) return submaps.status();
    sessions.emplace_back(MakeSession(number, options.robots).id, *submaps);
    std::fprintf(stderr, "%.2f GB in %zu sessions\n", BytesOnDisk(folder) / 1e9, sessions.size());
  }
  storage::WriteBatch batch;
  for (size_t one = 0; one < sessions.size(); ++one) {
    for (size_t other = one + 1; other < sessions.size(); ++other) {
      Compare(sessions, one, other, &batch);
    }
  }
  return (*store)->Write(batch);
}

}  // namespace isthmus::bench
