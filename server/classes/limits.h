// Sizes of what is looked at to tell what a point is of.
//
// Chosen for LiDARs of 16 to 128 rings in buildings and streets, before any forest was trained.
#pragma once

#include <cstddef>
#include <cstdint>

namespace isthmus::classes {

// Edge of the finest cells whose points are summed, metres, and levels of cells of twice the edge.
// The shape around a point is that of 2 x 2 x 2 cells: of 0.4, 0.8, 1.6 and 3.2 m.
inline constexpr double kCellM = 0.2;
inline constexpr int kLevels = 4;

// Edge of a cell of the ground, metres; columns are half as wide.
inline constexpr double kTerrainCellM = 0.8;
// Cells of the ground at most; where there would be more they are larger.
inline constexpr double kMostTerrainCells = 1 << 18;
// Metres by which the ground rises from a cell to the next: kerbs, and slopes of 20 degrees. With
// more, low furniture on floors that are not seen below it would be ground; stairs are told by
// their shape.
inline constexpr float kGroundStepM = 0.3F;
// Metres below the sensor, and around it, in which its ground is looked for.
inline constexpr float kHighestSensorM = 2.8F, kLowestSensorM = 0.15F;
inline constexpr int kSensorGroundCells = 5;
// The sensor's height where no ground is found, metres: a small robot's.
inline constexpr float kUnknownSensorHeightM = 0.5F;

// Height of a bin of a column, the lowest bin's bottom above the ground, and their number.
inline constexpr float kBinM = 0.2F, kLowestBinM = -0.6F;
inline constexpr int kBins = 64;
// Bins of which a column that is an obstacle has any: from 0.4 to 2 m above the ground.
inline constexpr int kFirstObstacleBin = 5, kEndObstacleBin = 13;
// Columns to either side in which the course of obstacles is looked at.
inline constexpr int kCourseColumns = 3;

// Cosines of the angles within which a surface is level or upright, and rounds in which up is
// estimated.
inline constexpr double kLevelCosine = 0.9, kUprightCosine = 0.26;
inline constexpr int kUpRounds = 3;
// The level whose cells tell up, the least planar of them, and the points in these without which
// nothing is known of it.
inline constexpr int kUpLevel = 2;
inline constexpr float kEvenShape = 0.5F;
inline constexpr double kFewestUpPoints = 300;

// A class less probable than this is unknown.
inline constexpr float kKnown = 0.4F;

}  // namespace isthmus::classes
