// The work of matching: two sessions' maps, a session's plan with those of others, and a session's
// newest submaps searched for loops.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/map/anchor.h"
#include "core/map/loop_closure.h"
#include "core/map/match.h"
#include "core/pose.h"
#include "server/jobs/job_key.h"
#include "server/matching/loops/loop_finder.h"
#include "server/matching/pairs/matcher.h"
#include "server/matching/pairs/matcher_options.h"
#include "server/matching/prepared/session_shape.h"

namespace isthmus::server {

// The submaps of a session that are to be matched, and their poses.
struct JobMapInput {
  SessionId session = {};
  std::vector<uint32_t> submaps = {};                // Their indices,
  std::vector<int64_t> stamps_ns = {};               // their first stamps, as ids may come again,
  std::vector<Pose> T_odom_submap = {};              // and as to be matched: straightened by loops.
  std::optional<matching::SessionShape> shape = {};  // Unused where plans are compared.
};

// The map of those submaps as they lie, without a shape. They may be outlines.
JobMapInput MakeJobMapInput(const SessionId& session, const matching::SubmapList& submaps);

// All input of a match beside the submaps themselves, so that it comes out the same on every
// machine, and after any change of the map.
struct PairJob {
  JobMapInput a = {}, b = {};  // a.session < b.session.
  std::vector<Anchor> anchors = {};
  // The memory of the pair's last job, null where there was none; if that was before the server's
  // start, only its match is known.
  std::shared_ptr<const matching::PairMemory> memory = {};
  std::optional<Match> known = {};
  matching::MatcherOptions options = {};  // `stop` stays behind.
  matching::LoopOptions loops = {};       // For further meetings of an accepted pair.
  bool search = false;                    // As of PairMatcher::Update.
  int64_t posted_ns = 0;                  // Unix nanoseconds: when all this was so.
};

struct PairResult {
  Match match = {};
  std::shared_ptr<const matching::PairMemory> memory = {};  // For the next job of the pair.
};

// The same for the place index.
struct PlanJob {
  JobMapInput session = {};
  std::vector<JobMapInput> others = {};
};
// The score of the session's plan with another's; nothing where submaps of that one are gone.
struct PlanScore {
  SessionId other = {};
  std::optional<double> score = {};
  friend bool operator==(const PlanScore&, const PlanScore&) = default;
};
using PlanScores = std::vector<PlanScore>;  // In the order of the others.

// The same for a LoopQuery. Submaps that cannot be read are left out of the query.
struct LoopJob {
  JobMapInput session = {};
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

using Job = std::variant<PairJob, PlanJob, LoopJob>;
using JobResult = std::variant<PairResult, PlanScores, LoopResult>;

// A LoopJob is named by the last of its submaps.
JobKey KeyOfJob(const Job& job);

// As bytes for a JobQueue; of one version of the program, and with a checksum. An error for others.
// Equal maps have equal bytes.
std::string EncodeMap(const JobMapInput& map);
std::string EncodeJob(const Job& job);
absl::StatusOr<Job> DecodeJob(const std::string& bytes);
std::string EncodeResult(const JobResult& result);
// The result of the job of this name, a match, an index or a search for loops.
absl::StatusOr<JobResult> DecodeResult(const JobKey& key, const std::string& bytes);

}  // namespace isthmus::server
