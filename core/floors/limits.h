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

// The largest thing that is taken off the ground where it touches no wall, metres: larger ones may
// be walls between two doors.
inline constexpr double kLooseM = 1;
// Walls are thinner than the first, shafts and all that is outside thicker than the second, metres;
// furniture is between.
inline constexpr double kThickestWallM = 0.4, kThickestFurnitureM = 2;
// Two rooms are one if the neck between them is wider than this share of the narrower room.
inline constexpr double kNeckShare = 0.7;
// Beside a true neck is a wall: so many metres of it in line with the neck, within the second.
inline constexpr double kLeastWallM = 0.4, kWallReachM = 2.5;
// A thicker wall than most, up to the first, is told from furniture by going on alike on both sides
// of a door; it is looked at so far from the door's ends.
inline constexpr double kThickestLongWallM = 0.8, kWallBesideM = 0.3;
// Parts of a room that furniture parts have little of other rooms between them: this share of
// the convex hull of both.
inline constexpr double kMostBetween = 0.1;
// A smaller room is part of one beside, if a neck joins them that is more than a leak.
inline constexpr double kSmallestRoomM2 = 1.5, kWidestLeakM = 0.15;
// Narrower necks are no doors, metres: nobody goes through.
inline constexpr double kNarrowestDoorM = 0.4;
// A corridor joins two rooms at least and has the area of so many squares as wide as it is.
inline constexpr double kCorridorSquares = 4;
// Cells of a grid map in which rooms are looked for, 0.6 GB of memory: 280 m by 280 m at 0.05 m.
inline constexpr int64_t kMostRoomCells = 32'000'000;

}  // namespace isthmus::floors
