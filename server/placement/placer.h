// The placer: gives every submap of connected sessions a pose, from odometry, matches, loop
// closures and anchors in one pose graph.
//
// The paper stops at the spanning tree of the match graph, which gives each session one transform
// and leaves its drift in the map. Here that is the initial value, and the result where nothing
// closes. Then every submap is a node of its own (server/pose_graph/).
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/map/anchor.h"
#include "core/map/loop_closure.h"
#include "core/map/map_name.h"
#include "core/map/match.h"
#include "core/map/revision.h"
#include "server/pose_graph/information.h"

namespace isthmus::placement {

struct PlacerOptions {
  pose_graph::DriftModel drift;
  // Maps of at most so many submaps are optimised as a whole at any change; in larger ones a change
  // moves only its surroundings (pose_graph/optimize_around.h) ...
  size_t whole_up_to = 1000;
  // ... until so many changes have come, or more than so many edges at once.
  int whole_after = 10;
  size_t whole_above_edges = 60;
  // A submap that moves by less stays as published: no revision for the last digit.
  double min_move_m = 2e-4;
  double min_turn_rad = 1e-5;
  double max_seconds = 10;  // Limit of one optimisation; the best so far is taken then.
};

// A submap that is in the map.
struct Node {
  uint32_t index = 0;
  Pose T_odom_submap;
  Matrix6d drift_covariance = Matrix6d::Zero();  // As in Submap.
  // Since the session's submap before (retired or not), along the way; 0: as the crow flies.
  double travelled_m = 0;
};

struct Session {
  Placement tree;           // Poses by the spanning tree; `submaps` is not looked at.
  std::vector<Node> nodes;  // In order of index; gaps are submaps that were retired.
};

// The input of a placement. Everything that names a submap that is not among the nodes is passed
// over.
struct Input {
  std::vector<Session> sessions;   // In order of id.
  std::vector<Match> matches;      // Matches that carry or could: only accepted ones count.
  std::vector<LoopClosure> loops;  // Loops that a person rejected do not count.
  std::vector<Anchor> anchors;
};

// The edges that were kept: matches by pair, loop closures by id, in their order of edges.
struct EdgeStatus {
  std::map<std::pair<SessionId, SessionId>, std::vector<bool>> matches;
  std::map<uint64_t, std::vector<bool>> loops;
  std::map<SubmapId, bool> anchors;
};

struct Outcome {
  std::vector<Placement> placements;  // In order of session; sessions without nodes are left out.
  EdgeStatus edge_status;
  size_t nodes = 0, edges = 0;
  bool whole = false;  // Everything was optimised, not only the surroundings of the changes.
  bool converged = true;
  std::string trouble;  // The optimiser's reason to give up for the initial value; else empty.
};

// Keeps the last solution to go on from. Not thread safe but for WriteG2o. Deterministic for the
// same sequence of calls. A thing that goes away (a match or a loop rejected, an anchor taken back,
// a session deleted) leaves nothing behind that it had bent: its component goes on from how it lay
// before that came, if that is not long ago, and else begins from the spanning tree again. Retired
// submaps leave the rest where it is.
class Placer {
 public:
  explicit Placer(const PlacerOptions& options = {});
  ~Placer();
  Placer(Placer&&) noexcept;
  Placer& operator=(Placer&&) noexcept;

  // `previous` is the map that readers see now: the start of the search, and the poses to compare
  // with. Never fails: without an optimum the spanning tree's poses stand, and `trouble` says why.
  //
  // Matches by hand (reason BY_HAND) are not doubted; one without edges is taken to hold where its
  // two sessions are nearest to each other, to 5 cm and 0.5 degrees. All other edges, loop closures
  // and anchors may be discarded by graduated non-convexity.
  Outcome Place(const Input& input, const std::vector<Placement>& previous);

  // The graph of the last call as g2o text, with a comment line for every vertex's submap. Edges
  // that were discarded are left out. NotFound for a map that does not exist. May be called while
  // another thread is in Place.
  absl::StatusOr<std::string> WriteG2o(const MapName& map) const;

 private:
  struct Memory;
  PlacerOptions options_;
  std::unique_ptr<Memory> memory_;
};

// The differences between the placements, each submap once, in order of submap.
std::vector<SubmapMove> FindMoves(const std::vector<Placement>& before,
                                  const std::vector<Placement>& after);

}  // namespace isthmus::placement
