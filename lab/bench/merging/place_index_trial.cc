#include "lab/bench/merging/place_index_trial.h"

#include <absl/strings/str_format.h>

#include <algorithm>
#include <iostream>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "lab/bench/cpu_clock.h"
#include "lab/bench/merging/odom_frames.h"
#include "lab/bench/merging/place_index_table.h"
#include "lab/bench/merging/searched_pairs.h"
#include "lab/bench/merging/seen_surface.h"
#include "server/matching/index/place_index.h"
#include "server/matching/index/plan_comparison.h"
#include "server/matching/index/session_plan.h"
#include "server/matching/prepared/prepared_map.h"

namespace isthmus::bench {
namespace {

// The drives of every world; in order of the worlds.
absl::StatusOr<std::map<uint64_t, std::vector<DriveOptions>>> DrivesByWorld(
    const WildPairsOptions& wild) {
  const auto pairs = DrawWildPairs(wild);
  if (!pairs.ok()) return pairs.status();
  std::map<uint64_t, std::vector<DriveOptions>> worlds;
  std::set<std::string> known;
  for (const WildPair& pair : *pairs) {
    if (pair.relation != WildRelation::kTeam) continue;
    for (const DriveOptions& drive : {pair.a, pair.b}) {
      if (known.insert(drive.Key()).second) worlds[drive.seed].push_back(drive);
    }
  }
  return worlds;
}

struct ComparedSession {
  SessionId id;
  std::string kind;
  uint64_t world = 0;
  int robot = 0;
  std::shared_ptr<const matching::SessionPlan> plan;
};

std::vector<DrivenRobot> CutDrive(const DrivenRobot& robot, int parts) {
  const uint64_t first = robot.poses.front().sequence, last = robot.poses.back().sequence + 1;
  std::vector<DrivenRobot> cut;
  for (int i = 0; i < parts; ++i) {
    DrivenRobot& part = cut.emplace_back(robot);
    KeepScans({i == 0 ? 0 : first + (last - first) * i / parts,
               i + 1 == parts ? UINT64_MAX : first + (last - first) * (i + 1) / parts - 1},
              &part);
  }
  return cut;
}

class IndexTrial {
 public:
  explicit IndexTrial(int parts) : parts_(parts) {}

  // Adds the sessions of a world. Robots that were lost all the way are left out.
  void AddWorld(uint64_t world, const std::vector<DriveOptions>& drives, DriveCache& cache) {
    const size_t begin = sessions_.size();
    std::vector<SeenSurface> seen;
    for (const DriveOptions& drive : drives) {
      auto robot = cache.Get(drive);
      if (!robot.ok()) {
        std::cerr << drive.Key() << ": " << robot.status() << std::endl;
        continue;
      }
      if (drive.robot > 0) MoveOdom(RandomFrame(world, drive.robot), &*robot);
      for (const DrivenRobot& part : CutDrive(*robot, parts_)) {
        seen.emplace_back(part);
        AddSession(drive, part);
      }
    }
    for (size_t a = begin; a < sessions_.size(); ++a) {
      for (size_t b = a + 1; b < sessions_.size(); ++b) {
        overlaps_[{a, b}] = SeenSurface::Overlap(seen[a - begin], seen[b - begin]);
      }
    }
    std::cerr << "world " << world << std::endl;
  }

  void Compare();
  // Has a server search all sessions; and each pair that overlaps be searched by itself.
  absl::Status Search(const server::PipelineOptions& options);
  const IndexResults& results() const { return results_; }

 private:
  void AddSession(const DriveOptions& drive, const DrivenRobot& part) {
    matching::PreparedSubmaps submaps;
    for (const auto& submap : part.submaps) submaps.push_back(matching::PrepareSubmap(submap));
    const CpuClock clock(CpuClock::Of::kProcess);
    ComparedSession& session = sessions_.emplace_back();
    session.plan =
        std::make_shared<const matching::SessionPlan>(matching::MakeSessionPlan(submaps));
    results_.plan_ms.push_back(clock.Ms());
    ++results_.sessions;
    results_.bytes += session.plan->bytes();
    robots_.push_back(part);
    Rename(&robots_.back(), absl::StrFormat("robot%05d", sessions_.size()));
    session.id = robots_.back().session.id;
    session.kind = drive.world;
    session.world = drive.seed;
    session.robot = drive.robot;
  }
  // Parts of one drive are no pair of sessions that anybody has.
  bool Counts(size_t a, size_t b) const {
    return sessions_[a].world != sessions_[b].world || sessions_[a].robot != sessions_[b].robot;
  }
  const int parts_;
  std::vector<ComparedSession> sessions_;
  std::vector<DrivenRobot> robots_;  // In the order of `sessions_`.
  std::map<std::pair<size_t, size_t>, double> overlaps_;
  IndexResults results_;
};

void IndexTrial::Compare() {
  matching::PlaceIndex index;
  std::map<std::pair<SessionId, SessionId>, size_t> known;
  for (size_t a = 0; a < sessions_.size(); ++a) {
    matching::PlanComparer comparer(sessions_[a].plan);
    for (size_t b = a + 1; b < sessions_.size(); ++b) {
      if (!Counts(a, b)) continue;
      const CpuClock clock(CpuClock::Of::kProcess);
      index.Put(sessions_[a].id, sessions_[b].id, comparer.Score(*sessions_[b].plan));
      results_.compare_ms.push_back(clock.Ms());
      known[{sessions_[a].id, sessions_[b].id}] = results_.pairs.size();
      ComparedPair& pair = results_.pairs.emplace_back();
      if (sessions_[a].kind == sessions_[b].kind) pair.kind = sessions_[a].kind;
      const auto overlap = overlaps_.find({a, b});
      if (overlap != overlaps_.end()) pair.overlap = overlap->second;
      pair.a = static_cast<int>(a);
      pair.b = static_cast<int>(b);
    }
  }
  const auto ranked = index.Rank(sessions_.size());
  for (size_t i = 0; i < ranked.size(); ++i) {
    results_.pairs[known.at(ranked[i].sessions)].place =
        static_cast<double>(i) / static_cast<double>(ranked.size());
  }
  for (const size_t partners : kPartnerCounts) {
    for (const auto& pair : matching::TakePartners(index.Rank(partners), partners)) {
      results_.pairs[known.at(pair.sessions)].partners.insert(partners);
    }
  }
}

absl::Status IndexTrial::Search(const server::PipelineOptions& options) {
  std::set<SessionPair> overlapping;
  const auto ids_of = [this](const ComparedPair& pair) {
    return SessionPair(sessions_[pair.a].id, sessions_[pair.b].id);
  };
  for (const ComparedPair& pair : results_.pairs) {
    if (pair.overlap >= kLeastOverlap) overlapping.insert(ids_of(pair));
  }
  const auto found = SearchAll(robots_, overlapping, options);
  if (!found.ok()) return found.status();
  const auto server = SearchAsServer(robots_, options);
  if (!server.ok()) return server.status();
  results_.server.emplace();
  results_.server->looks = server->looked_at.size();
  results_.server->searches = server->searched.size();
  results_.server->cpu_s = server->cpu_s;
  for (ComparedPair& pair : results_.pairs) {
    const SessionPair ids = ids_of(pair);
    pair.is_found = found->contains(ids);
    pair.is_searched = server->searched.contains(ids);
    pair.is_accepted = server->accepted.contains(ids);
    pair.is_joined = server->components.at(ids.first) == server->components.at(ids.second);
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status DriveForPlaceIndex(const PlaceIndexOptions& options, DriveCache& cache) {
  const auto worlds = DrivesByWorld(options.wild);
  if (!worlds.ok()) return worlds.status();
  for (const auto& [seed, drives] : *worlds) {
    for (const DriveOptions& drive : drives) {
      if (absl::Status status = cache.Fill(drive); !status.ok()) {
        std::cerr << drive.Key() << ": " << status << std::endl;
      }
    }
  }
  return absl::OkStatus();
}

absl::Status RunPlaceIndex(const PlaceIndexOptions& options, DriveCache& cache, std::ostream& out) {
  const auto worlds = DrivesByWorld(options.wild);
  if (!worlds.ok()) return worlds.status();
  IndexTrial trial(options.parts);
  for (const auto& [seed, drives] : *worlds) trial.AddWorld(seed, drives, cache);
  trial.Compare();
  if (options.search) {
    if (absl::Status status = trial.Search(options.server); !status.ok()) return status;
  }
  out << PlaceIndexTable(trial.results());
  return absl::OkStatus();
}

}  // namespace isthmus::bench
