// Limits of segments: how a drive begins, how long doubt and a search last, what standing still is.
//
// "A guess": nothing that is recorded says that another value was tried. When submaps are cut is in
// SubmapOptions, what a match must show in OdometryOptions.
#pragma once

namespace isthmus::floam {

// The beginning (segment.cc).

// Scans after the first that may fail to match it, and seconds after which none is matched to it
// any more, before it begins anew. Guesses.
inline constexpr int kStartAttempts = 3;
inline constexpr double kLongestStartS = 5;

// Doubt (segment.cc).

// Scans in a row that may match unusually badly before the robot counts as lost (decision 0015).
inline constexpr int kMostDoubtful = 10;
// Seconds between looks at the walls around, for time (decision 0019).
inline constexpr double kWallLookS = 3;

// Patience (odometry.cc, decision 0014), seconds. A robot that is lost is looked for in what it has
// seen for so long, and then begins anew; where that was next to nothing, because it began badly,
// sooner. If beginning anew soon fails too, because there is nothing to go by, the wait doubles
// from one segment to the next up to the longest. Guesses.
inline constexpr double kPatienceS = 2;
inline constexpr double kLeastPatienceS = 0.3;
inline constexpr double kLongestPatienceS = 60;
// A segment was worth beginning if scans were matched for this long. A guess.
inline constexpr double kWorthwhileS = 5;

// Standing still (submap_builder.cc): less motion than this, m and rad, is noise of the poses. A
// guess; less, and a robot that stands makes keyframes.
inline constexpr double kMovedM = 0.05;
inline constexpr double kMovedRad = 0.02;

}  // namespace isthmus::floam
