// The result of matching two sessions' maps, accepted or not.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/ids.h"
#include "core/pose.h"

namespace isthmus {

enum class MatchState {
  kAccepted,   // Verified; the edge may carry a merge.
  kRejected,   // A hypothesis was found and contradicted.
  kAmbiguous,  // Two or more hypotheses explain the maps about equally well.
  kNotYet,     // Too little evidence; tried again when more submaps have come.
};

// Stable upper-case name ("ACCEPTED"); used in JSON, storage and messages.
const char* ToString(MatchState state);

// The reason for a match's state; docs/concepts.md says what each means, and what one can do.
enum class MatchReason {
  kNone,  // Nothing was computed yet.
  kOk,
  kByHand,
  kFreeSpace,
  kPossibleTwin,
  kAmbiguous,
  kCycle,
  kGroup,  // Open by itself; settled by matches of these two sessions with others.
  kLowOverlap,
  kLoose,
  kTooSmall,
  kFewComparisons,
  kDegenerate,
  kStrained,
  kNotConverged,
  kNoCandidate,
  kNoPoses,  // For finished maps only, like the next.
  kUnverified,
};

// Stable upper-case name ("FREE_SPACE"), empty for kNone; used in JSON, storage and messages.
const char* ToString(MatchReason reason);
// Also of names that were in use before; kNone for a name that is not known.
MatchReason ParseMatchReason(std::string_view name);

// The source of a transform's guess, before it was refined and checked.
enum class GuessSource {
  kNone,
  kOdometry,
  kPlaces,
  kBirdsEye,
  kStructure,
  kRepeats,  // Another hypothesis, moved by what one of the maps repeats.
  kAnchors,
  kPaper,
  kByHand,
};

// Stable lower-case name ("birds_eye"), empty for kNone; used in JSON and storage.
const char* ToString(GuessSource source);
// kNone for a name that is not known.
GuessSource ParseGuessSource(std::string_view name);

// One submap of a lies on one submap of b: what a pose graph is made of.
struct SubmapEdge {
  uint32_t submap_a = 0;  // Index of the submap in its session.
  uint32_t submap_b = 0;
  Pose T_a_b;  // Takes a point of the submap of b to the frame of the submap of a.
  // The information of the twist [rho; phi] in the frame of submap a by which the true pose is
  // Exp(twist) T_a_b.
  Matrix6d information = Matrix6d::Zero();
};

struct StageTime {
  std::string stage;  // "voxel_filter", "fpfh", "birds_eye", "vgicp", ...
  double ms = 0;      // Wall time.
};

// Another way in which the two maps of a match could lie on each other, looked at as closely as the
// best one. Numbers as of a Match.
struct RivalMatch {
  Pose T_a_b;
  MatchState state = MatchState::kNotYet;  // By itself; kRejected: contradicted.
  MatchReason reason = MatchReason::kNone;
  double confidence = 0;
  GuessSource matcher = GuessSource::kNone;
  double overlap = -1;
  double free_space = -1;
  int64_t comparisons = -1;
  double shared_area_m2 = -1;
  std::vector<SubmapEdge> edges;  // None where it is contradicted.
};

// A point of a way, told by a submap near it, so that it moves with the map.
struct WayPoint {
  uint32_t submap = 0;                                 // Index of the submap in its session.
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  // The sensor's, in the submap's frame.
};

// A drive of one robot that would tell whether the maps of a match that waits lie as one of its
// hypotheses has them: along its own way, and on along the other robot's.
struct AskedDrive {
  bool by_b = false;          // The robot of b drives, else that of a.
  uint32_t rival = 0;         // The hypothesis in question: 0 the match's own, i its i-th rival.
  std::vector<WayPoint> way;  // From the newest pose on; submaps of the session that drives.
  uint32_t leaves_own = 0;    // The last point of `way` where that robot has been.
  double length_m = 0;
  double confidence = 0;  // The match's afterwards, if the maps do lie like that.
};

// A match of the ordered pair (a, b), a < b. Numbers that a stage did not compute stay at -1.
struct Match {
  SessionId a;
  SessionId b;
  Pose T_a_b;  // Takes a point of b's odom frame to a's.
  MatchState state = MatchState::kNotYet;
  MatchReason reason = MatchReason::kNone;
  std::string detail;          // One sentence for a person, with the numbers.
  double confidence = 0;       // Probability of being right, [0, 1]; weight in the match graph.
  double overlap = -1;         // Share of the smaller map's surface that lies on the other, [0, 1].
  int64_t inliers = -1;        // Correspondences that agree with T_a_b.
  double inlier_ratio = -1;    // Their share of the points that have the other map near, [0, 1].
  double residual_m = -1;      // RMS point-to-surface distance of the inliers.
  double free_space = -1;      // Share of contradicted range comparisons, [0, 1]; 0 is best.
  int64_t comparisons = -1;    // Number of comparisons that free_space rests on.
  double runner_up = -1;       // free_space of the best competing hypothesis.
  double shared_area_m2 = -1;  // Ground that both robots looked across.
  double observability = -1;   // Mean squared normal along the direction held least; 0: it slides.
  double odometry_residual = -1;  // Bend of the odometry to fit, RMS in its standard deviations.
  // The residual of going round the best cycle of accepted matches through this one.
  double cycle_m = -1, cycle_deg = -1;
  uint32_t candidates = 0;  // Guesses that were refined.
  GuessSource matcher = GuessSource::kNone;
  uint32_t submaps_a = 0;  // Evidence it was computed from, to know when it is out of date.
  uint32_t submaps_b = 0;
  int64_t computed_ns = 0;  // Unix nanoseconds.
  std::vector<StageTime> stages;
  // Edges between their submaps; at least one of an accepted match that was computed.
  std::vector<SubmapEdge> edges;
  std::vector<RivalMatch> rivals;  // The better ones first; of a computed match only.
  // The drives that would tell most for their length, the best first, one for each robot at most;
  // none where the match is accepted or no way leads to what would tell.
  std::vector<AskedDrive> asked;
};

}  // namespace isthmus
