// Limits of finding and following a robot in a map that it does not add to.
//
// Guesses, unless something else is said.
#pragma once

#include <cstddef>

namespace isthmus::floam {

// Voxels of a map to be found in: 480 MB, some ten hectares of buildings or 20 km of streets.
inline constexpr size_t kMostMapVoxels = 40'000'000;

// Drift of odometry per metre of the way (m) and per radian turned (rad): one sigma. Drives in
// simulated museums drift by less than a tenth of that, on open roads by as much.
inline constexpr double kDriftPerM = 0.01;
inline constexpr double kDriftRadPerM = 0.001;
inline constexpr double kDriftPerRad = 0.01;
// One sigma of what a map's voxels lie off, m and rad: they hold one point each, with its noise.
inline constexpr double kMapNoiseM = 0.01;
inline constexpr double kMapNoiseRad = 0.002;

// A scan may lie on the map this far (sigmas), and this much besides (m, rad), from where it is
// expected.
inline constexpr double kGateSigmas = 3;
inline constexpr double kGateM = 0.15;
inline constexpr double kGateRad = 0.03;

// Seconds of scans that the map contradicts, after which the robot is looked for anew.
inline constexpr double kContradictedS = 2;
// Metres, one sigma: beyond the first a place is uncertain, beyond the second it is not known.
inline constexpr double kUncertainM = 0.3;
inline constexpr double kUnknownM = 5;

// Share of a map's walls, beyond the usual one, that a scan looks through where it contradicts the
// map: things are moved from day to day, walls are not.
inline constexpr double kMoreThroughMap = 0.3;

// Seconds between looks at the walls that a scan sees through, while it fits: they take as long as
// the match.
inline constexpr double kWallsEveryS = 1;

}  // namespace isthmus::floam
