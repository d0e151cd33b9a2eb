// Limits of floors and of the grid maps that are drawn of them.
#pragma once

#include <cstdint>

namespace isthmus::floors {

// Metres that a robot goes between two places that floors are told by. A scan is 0.1 to 0.5 m of
// way; finer ones would only say the same.
inline constexpr double kStationM = 0.5;
// Height of the bins in which a robot's way is counted, and the gap between two floors at least.
// Storeys are 2.4 m apart or more, and a sensor on a walking robot swings by half a metre.
inline constexpr double kFloorBinM = 0.25, kFloorGapM = 1.5;
// Share of the fullest bin, and stations, that a bin must have to belong to a floor. Stairs have
// about a metre of way in each bin; a floor has tens.
inline constexpr double kFloorShare = 0.05;
inline constexpr int kFloorStations = 6;
// Metres below a sensor in which its ground is looked for. Cars carry it at 2 m; deeper than this
// lies another storey.
inline constexpr double kDeepestGroundM = 2.8;
// The sensor's height above the ground where no ground was found under it, metres: a small robot's.
inline constexpr double kUnknownSensorHeightM = 0.5;
// Things that begin so high above the ground are in a robot's way, metres: above sills and what
// noise and slopes add, and one voxel more. The second value: up to so much above the sensor that
// made the map.
inline constexpr double kLowestObstacleM = 0.1, kAboveSensorM = 0.3;
// Metres along a cell of the field of station heights. Ramps of 15 % rise 8 cm in it, less than
// what is no obstacle yet.
inline constexpr double kHeightCellM = 0.5;
// Edge of a cell unless told otherwise, metres: what Nav2's own maps have.
inline constexpr double kGridCellM = 0.05;
// Cells of a grid map, 400 MB of memory: 1 km by 1 km at 0.05 m. Larger ones no planner loads.
inline constexpr int64_t kMostCells = 400'000'000;

}  // namespace isthmus::floors
