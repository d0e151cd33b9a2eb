// The work of workers: matching two sessions' maps, comparing a session's plan with those of
// others, and searching a session's newest submaps for loops.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/map/anchor.h"
#include "core/map/loop_closure.h"
#include "core/map/match.h"
#include "core/pose.h"
#include "server/matching/loops/loop_finder.h"
#include "server/matching/pairs/matcher_options.h"
#include "server/matching/prepared/session_shape.h"

namespace isthmus::server {

// Which submaps of a session are to be matched, and how they lie.
struct MapOfJob {
  SessionId session = {};
  std::vector<uint32_t> submaps = {};                // Their indices,
  std::vector<int64_t> stamps_ns = {};               // their first stamps, as ids may come again,
  std::vector<Pose> T_odom_submap = {};              // and as to be matched: straightened by loops.
  std::optional<matching::SessionShape> shape = {};  // Of no account where plans are compared.
};

// Those submaps as they lie, without a shape. They may be outlines.
MapOfJob MakeMapOfJob(const SessionId& session, const matching::SubmapList& submaps);

// All that the match follows from beside the submaps themselves, so that it comes out the same
// whoever computes it, and whatever became of the map meanwhile.
struct PairJob {
  MapOfJob a = {}, b = {};  // a.session < b.session.
  std::vector<Anchor> anchors = {};
  std::optional<Match> known = {};        // From before.
  matching::MatcherOptions options = {};  // `stop` stays behind.
  bool search = false;                    // As of PairMatcher::Update.
  int64_t posted_ns = 0;                  // Unix nanoseconds: when all this was so.
};

// The same for the place index.
struct PlanJob {
  MapOfJob session = {};
  std::vector<MapOfJob> others = {};
};
// Of the session with each of the others, in their order; nothing for one whose submaps are gone.
using PlanScores = std::vector<std::optional<double>>;

// The same for a LoopQuery.
struct LoopJob {
  MapOfJob session = {};
  std::vector<Pose> T_map_submap = {};
  uint64_t first_new = 0;
  std::vector<LoopClosure> known = {};
  matching::LoopMemory memory = {};
  matching::LoopOptions options = {};
};
struct LoopResult {
  std::vector<LoopClosure> found = {};
  matching::LoopMemory memory = {};  // For the next job of the session.
};

// As bytes for a JobBoard; of one version of the program, and with a checksum. An error for others.
// Equal maps have equal bytes.
std::string EncodeMap(const MapOfJob& map);
std::string EncodePairJob(const PairJob& job);
absl::StatusOr<PairJob> DecodePairJob(const std::string& bytes);
std::string EncodePlanJob(const PlanJob& job);
absl::StatusOr<PlanJob> DecodePlanJob(const std::string& bytes);
bool IsPlanJob(const std::string& bytes);
std::string EncodeLoopJob(const LoopJob& job);
absl::StatusOr<LoopJob> DecodeLoopJob(const std::string& bytes);
bool IsLoopJob(const std::string& bytes);
std::string EncodeMatch(const Match& match);
absl::StatusOr<Match> DecodeMatch(const std::string& bytes);
std::string EncodePlanScores(const PlanScores& scores);
absl::StatusOr<PlanScores> DecodePlanScores(const std::string& bytes);
std::string EncodeLoopResult(const LoopResult& result);
absl::StatusOr<LoopResult> DecodeLoopResult(const std::string& bytes);

}  // namespace isthmus::server
