#include "lab/bench/merging/trial.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <limits>
#include <set>
#include <utility>

#include "client/evaluation/trajectory_error.h"
#include "lab/bench/cpu_clock.h"
#include "lab/bench/merging/seen_surface.h"
#include "server/pipeline.h"
#include "storage/memory_store.h"

namespace isthmus::bench {
namespace {

constexpr double kRightM = 0.3, kRightDeg = 1.0;
constexpr double kHypothesisM = 0.5, kHypothesisDeg = 2.0;
constexpr double kFrameM = 1.0, kFrameDeg = 3.0;

bool IsLarge(const MapError& error) {
  return error.median_m > kRightM || error.median_deg > kRightDeg;
}

// No one transform is right if drift has bent the common part by more than a match may be off:
// right edges are enough then, as the map is made of them.
bool IsRight(const PairTruth& truth, const PairResult& pair) {
  if (truth.IsWithin(pair.match.T_a_b, kRightM, kRightDeg)) return true;
  return truth.HasTransform() && IsLarge(pair.drift) && !pair.match.edges.empty() &&
         !IsLarge(pair.edges);
}

PairResult MeasurePair(const DrivenRobot& a, const DrivenRobot& b, const Match& match) {
  PairResult result;
  result.match = match;
  const PairTruth truth(a, b);
  result.hypothesis_right = truth.IsWithin(match.T_a_b, kHypothesisM, kHypothesisDeg);
  for (const RivalMatch& rival : match.rivals) {
    result.rivals_right.push_back(truth.IsWithin(rival.T_a_b, kHypothesisM, kHypothesisDeg));
  }
  if (truth.HasTransform()) {
    result.map = truth.ErrorOf(match.T_a_b);
    result.start = truth.StartErrorOf(match.T_a_b);
    result.drift = truth.drift();
    result.edges = ErrorOfEdges(a, b, match.edges);
  }
  if (match.state == MatchState::kAccepted) {
    result.outcome = IsRight(truth, result) ? TrialOutcome::kRight : TrialOutcome::kWrong;
  }
  return result;
}

std::vector<PairResult> JudgePairs(const std::vector<DrivenRobot>& robots,
                                   const std::vector<MatchEdge>& matches) {
  std::vector<SeenSurface> seen;
  seen.reserve(robots.size());
  for (const DrivenRobot& robot : robots) seen.emplace_back(robot);
  std::vector<PairResult> pairs;
  for (size_t a = 0; a < robots.size(); ++a) {
    for (size_t b = a + 1; b < robots.size(); ++b) {
      const auto it = std::find_if(matches.begin(), matches.end(), [&](const MatchEdge& edge) {
        return edge.match.a == robots[a].session.id && edge.match.b == robots[b].session.id;
      });
      PairResult& pair = pairs.emplace_back(
          MeasurePair(robots[a], robots[b], it == matches.end() ? Match() : it->match));
      pair.a = static_cast<int>(a);
      pair.b = static_cast<int>(b);
      if (robots[a].ground == robots[b].ground) {
        pair.overlap = SeenSurface::Overlap(seen[a], seen[b]);
      }
    }
  }
  return pairs;
}

// Finds the robots that share a frame, and judges their poses in it.
void JudgeFrames(const std::vector<DrivenRobot>& robots, const std::vector<PlacedSession>& placed,
                 Trial* trial) {
  std::vector<const Placement*> placements;
  for (const DrivenRobot& robot : robots) {
    const auto found = std::find_if(placed.begin(), placed.end(), [&](const PlacedSession& p) {
      return p.placement.session == robot.session.id;
    });
    placements.push_back(found == placed.end() ? nullptr : &found->placement);
    const auto alone = static_cast<uint32_t>(placed.size() + trial->frames.size());
    trial->frames.push_back(found == placed.end() ? alone : found->placement.component);
  }
  for (PairResult& pair : trial->pairs) {
    const Placement *a = placements[pair.a], *b = placements[pair.b];
    if (a == nullptr || b == nullptr || a->component != b->component) continue;
    const PairTruth truth(robots[pair.a], robots[pair.b]);
    pair.frame_wrong = !truth.IsWithin(a->T_map_odom.Inverse() * b->T_map_odom, kFrameM, kFrameDeg);
  }
}

double AlignedRmse(const std::vector<evaluation::TrajectoryPair>& team) {
  const auto errors = evaluation::CompareTrajectories(team);
  return errors.ok() ? errors->all.rmse_m : std::numeric_limits<double>::quiet_NaN();
}

// The robots' trajectories as the map has them, bent to follow their submaps: each by itself, and
// all in one frame if they are.
void JudgeTeam(const std::vector<DrivenRobot>& robots, server::Pipeline& pipeline, Trial* trial) {
  std::vector<evaluation::TrajectoryPair> team;
  std::multiset<uint32_t> components;
  for (const DrivenRobot& robot : robots) {
    auto in_map = pipeline.reader().GetTrajectory(robot.session.robot, TrajectoryFrame::kMap);
    if (!in_map.ok() || in_map->poses.empty()) return;
    components.insert(in_map->component);
    evaluation::TrajectoryPair& pair = team.emplace_back();
    pair.name = robot.session.robot.value();
    pair.estimate = std::move(in_map->poses);
    for (const ScanPose& pose : robot.poses) {
      pair.truth.push_back({pose.stamp_ns, pose.T_world_sensor});
    }
  }
  for (size_t i = 0; i < robots.size(); ++i) {
    if (components.count(trial->frames[i]) < 2) continue;
    trial->joined.push_back(
        {.odometry_m = robots[i].OdometryRmse(), .bent_m = AlignedRmse({team[i]})});
  }
  if (components.count(*components.begin()) != robots.size()) return;
  trial->one_frame = true;
  const auto errors = evaluation::CompareTrajectories(team);
  if (!errors.ok()) return;
  trial->team_rmse_m = errors->all.rmse_m;
  trial->robots = trial->joined;
  for (size_t i = 0; i < robots.size(); ++i) trial->robots[i].joined_m = errors->robots[i].rmse_m;
}

// Accepts what was found of pairs where it is right and the server does not believe it.
absl::Status AcceptRight(const std::vector<DrivenRobot>& robots, server::Pipeline& pipeline) {
  const std::vector<MatchEdge> found = pipeline.reader().GetMatchGraph().matches;
  for (const PairResult& pair : JudgePairs(robots, found)) {
    if (pair.outcome != TrialOutcome::kNotMerged || !pair.hypothesis_right) continue;
    if (!pair.HasHypothesis()) continue;
    MatchDecision decision;
    decision.session_a = pair.match.a;
    decision.session_b = pair.match.b;
    decision.kind = ManualDecisionKind::kAccept;
    const auto decided = pipeline.decisions().DecideMatch(decision);
    if (!decided.ok()) return decided.status();
  }
  pipeline.WaitUntilIdle();
  return absl::OkStatus();
}

// The sessions are opened, and their trajectories are not known.
absl::Status Grow(const std::vector<DrivenRobot>& robots, server::Pipeline& pipeline) {
  size_t most = 0;
  for (const DrivenRobot& robot : robots) {
    const auto session = pipeline.sessions().Create({robot.session.robot, robot.session.sensor});
    if (!session.ok()) return session.status();
    most = std::max(most, robot.submaps.size());
  }
  for (size_t k = 0; k < most; ++k) {
    for (const DrivenRobot& robot : robots) {
      if (k >= robot.submaps.size()) continue;
      const auto added = pipeline.sessions().AddSubmap(Submap(*robot.submaps[k]));
      if (!added.ok()) return added.status();
      pipeline.WaitUntilIdle();
    }
  }
  for (const DrivenRobot& robot : robots) {
    const auto finished = pipeline.sessions().Finish(robot.session.id);
    if (!finished.ok()) return finished.status();
  }
  return absl::OkStatus();
}

}  // namespace

void NameInOrder(std::vector<DrivenRobot>* robots) {
  char letter = 'a';
  for (DrivenRobot& robot : *robots) Rename(&robot, std::string("robot_") + letter++);
}

absl::StatusOr<std::unique_ptr<storage::MapStore>> StoreOf(const std::vector<DrivenRobot>& robots) {
  auto store = storage::MakeMemoryStore();
  storage::WriteBatch batch;
  for (const DrivenRobot& robot : robots) {
    batch.sessions.push_back(robot.session);
    for (const ScanPose& pose : robot.poses) {
      batch.trajectory.push_back(
          {robot.session.id, {pose.sequence, pose.stamp_ns, pose.T_odom_sensor, pose.submap}});
    }
    batch.submaps.insert(batch.submaps.end(), robot.submaps.begin(), robot.submaps.end());
    batch.anchors.insert(batch.anchors.end(), robot.anchors.begin(), robot.anchors.end());
    for (LoopClosure loop : robot.loops) {
      loop.id = batch.loops.size() + 1;
      loop.session = robot.session.id;
      batch.loops.push_back(std::move(loop));
    }
    if (robot.submaps.empty()) continue;
    // Loops are as the robots have them.
    batch.matching_progress.push_back(
        {.session = robot.session.id, .next_for_loops = robot.submaps.back()->id.index + 1});
  }
  if (absl::Status status = store->Write(batch); !status.ok()) return status;
  return store;
}

absl::StatusOr<Trial> RunTrial(std::vector<DrivenRobot> robots,
                               const server::PipelineOptions& options, const TrialOptions& how) {
  NameInOrder(&robots);
  auto store = StoreOf(how.grow ? std::vector<DrivenRobot>() : robots);
  if (!store.ok()) return store.status();
  Trial trial;
  trial.world = robots[0].ground.substr(0, robots[0].ground.rfind('-'));
  for (const DrivenRobot& robot : robots) {
    trial.submaps += robot.submaps.size();
    trial.lost_scans += robot.lost_scans;
    trial.loops += robot.loops.size();
    trial.odometry_m = std::max(trial.odometry_m, robot.OdometryRmse());
  }
  const CpuClock clock(CpuClock::Of::kProcess);
  const auto pipeline = server::Pipeline::Open(options, *std::move(store));
  if (!pipeline.ok()) return pipeline.status();
  if (how.grow) {
    if (absl::Status status = Grow(robots, **pipeline); !status.ok()) return status;
  }
  (*pipeline)->WaitUntilIdle();
  trial.cpu_ms = clock.Ms();
  trial.estimation_ms = (*pipeline)->GetMapInfo().estimation_ms;
  if (how.accept_right) {
    if (absl::Status status = AcceptRight(robots, **pipeline); !status.ok()) return status;
  }
  const MatchGraph graph = (*pipeline)->reader().GetMatchGraph();
  if (graph.matches.size() != robots.size() * (robots.size() - 1) / 2) {
    return absl::InternalError("the server is idle, but not every pair has been looked at");
  }
  trial.pairs = JudgePairs(robots, graph.matches);
  JudgeFrames(robots, graph.placements, &trial);
  JudgeTeam(robots, **pipeline, &trial);
  if (trial.one_frame) trial.sharpness = MeasureSharpness(robots, **pipeline);
  return trial;
}

}  // namespace isthmus::bench
