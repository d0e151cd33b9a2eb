// Limits of matching: what a match is worth, what is observed, and whether it is to be believed.
//
// "A guess": nothing that is recorded says that another value was tried. Iterations, losses and
// noise are in MatchOptions and ScanToScanOptions.
#pragma once

namespace isthmus::floam {

// Matches at least, of a scan to the map or to the scan before, for it to be believed. A guess: ten
// for each of the six unknowns.
inline constexpr int kMinMatches = 60;
// Rough matching: every so manieth feature or wall is enough, for a third of the time. And metres,
// the scale of the loss at first where a guess is off by half a metre, or the map is one scan.
// Guesses.
inline constexpr int kRoughStride = 3;
inline constexpr double kRoughKernelM = 1.0;
// The ground's normal: steeper is no ground, even seen at a tilt (37 degrees).
inline constexpr float kGroundNormalZ = 0.8F;

// Information in matches (match_information.cc).

// So many matches may be wrong without deciding anything: a handful of points far away on an open
// road, or on something that moves (decision 0015).
inline constexpr double kWrongMatches = 6;
// Directions about which the matches say so many times more than the prior need no second look: a
// matter of time. A guess.
inline constexpr double kCertainRatio = 200;
// Cosine, 75 degrees: matches that hold a direction at a steeper slant do so by what their normals
// are off. A tunnel without a mark, and roads (decision 0016); X-ICP counts alike.
inline constexpr double kPlainCosine = 0.25;

// Changes of the motion (motion_model.cc): densities of white noise.

// m^2/s^3, 0.7 m/s in a second. Cars brake harder, which scans show; where they do not, a motion
// that mostly goes on is the better guess. A recorded street, a bare corridor and two tunnels.
inline constexpr double kAccelerationNoise = 0.5;
// The least of it while the motion is steady, 0.07 m/s in a second (decision 0017).
inline constexpr double kLeastAccelerationNoise = 0.005;
// rad^2/s^3: 0.45 rad/s in a second. A guess.
inline constexpr double kTurningNoise = 0.2;

// Motion that is not observed (unobserved_motion.cc, pose_covariance.cc).

// Densities, m^2/s^3 and rad^2/s^3. After kSpeedKnownS the speed is as uncertain as it can be, 1
// m/s, and the rate of turning, 0.3 rad/s: robots brake, stop and turn in a second. Guesses.
inline constexpr double kUnobservedAcceleration = 1;
inline constexpr double kUnobservedTurning = 0.1;
inline constexpr double kSpeedKnownS = 1;
// Seconds that a direction counts as not observed after it was not: bare fields and tunnels
// (decision 0018); less, and claims to be ok come by chance.
inline constexpr double kUnobservedLastsS = 0.55;
// Sigma of poses, m and rad: along what is not observed, and of a prediction only. Guesses; too
// small, and who uses them believes what nobody saw.
inline constexpr double kUnobservedM = 1.0;
inline constexpr double kUnobservedRad = 0.2;
inline constexpr double kLostM = 10;
inline constexpr double kLostRad = 1;

// Scan to scan (scan_to_scan.cc).

// Rows that six unknowns need. A guess.
inline constexpr int kMinScanRows = 10;
// Sine of the angle of three points: smaller is a line, not a plane. A guess.
inline constexpr float kLeastPlaneSine = 0.05F;
// Metres between two hits of one pole, at whatever height. A guess.
inline constexpr float kPoleLengthM = 3;
// The worth of a pole's match in planes': a plane is met by chance every other time, one of a
// hundred poles once in a few hundred times. Roads that begin at speed (decision 0016).
inline constexpr double kPoleWorth = 8;

// Belief in a match (match_quality.cc), relative to the fading averages of agreement and of the
// share of features used. New surroundings lower the share at once, but hardly the agreement. In
// museums and on campuses agreement never fell below 0.94 and the share below 0.9 of theirs; false
// minima lay below 0.77 and 0.8; 108 robots that were kidnapped (decision 0018).

// Weight of a scan in the averages. A guess: 2 s at 10 Hz.
inline constexpr double kQualityFading = 0.05;
// At the expected place; and the least share whatever the agreement: followed but in doubt, or at
// the edge of the map, where a part of what is seen is new.
inline constexpr double kUsualAgreement = 0.88;
inline constexpr double kUsualShare = 0.6;
inline constexpr double kDoubtfulAgreement = 0.7;
inline constexpr double kLowestShare = 0.4;
// Found again anywhere (0.92 and 0.95, 0.6 and 0.75 were tried before), or at the edge.
inline constexpr double kTypicalAgreement = 0.94;
inline constexpr double kTypicalShare = 0.85;
inline constexpr double kEdgeAgreement = 0.9;
// Edges and poles that lie on lines and poles: a tenth of the usual does in wrong places at most, a
// fifth in one right place of a hundred (forests and pipes, decision 0018); and the number that
// must be expected for that to tell.
inline constexpr double kUsualStanding = 0.15;
inline constexpr double kTypicalStanding = 0.4;
inline constexpr double kFewStanding = 8;

// Walls looked through (match_quality.cc): 0.03 where the robot is right indoors, 0.4 in forests,
// 0.8 in crowds; 93 robots that were found again, four of them elsewhere (decision 0019).

// Points of walls that must be in view: fewer tell nothing. A guess.
inline constexpr int kFewWalls = 200;
// The share beyond the usual that contradicts, and the weight of a look in the usual one.
inline constexpr double kMoreThroughUsual = 0.2;
inline constexpr double kWallsFading = 0.2;

}  // namespace isthmus::floam
