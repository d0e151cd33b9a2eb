// The matching of two sessions' maps as a job for a worker.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/map/anchor.h"
#include "core/map/match.h"
#include "core/pose.h"
#include "server/matching/pairs/matcher_options.h"
#include "server/matching/prepared/session_shape.h"

namespace isthmus::server {

// Which submaps of a session are to be matched, and how they lie.
struct MapOfJob {
  SessionId session = {};
  std::vector<uint32_t> submaps = {};    // Their indices,
  std::vector<int64_t> stamps_ns = {};   // their first stamps, as ids may come again,
  std::vector<Pose> T_odom_submap = {};  // and as to be matched: straightened by loops.
  std::optional<matching::SessionShape> shape = {};
};

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

// As bytes for a JobBoard; of one version of the program, and with a checksum. An error for others.
// Equal maps have equal bytes.
std::string EncodeMap(const MapOfJob& map);
std::string EncodePairJob(const PairJob& job);
absl::StatusOr<PairJob> DecodePairJob(const std::string& bytes);
std::string EncodeMatch(const Match& match);
absl::StatusOr<Match> DecodeMatch(const std::string& bytes);

}  // namespace isthmus::server
