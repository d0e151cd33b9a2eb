// Columns of a cloud: the heights at which they have points, and the courses that they stand in.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "server/classes/ground_grid.h"

namespace isthmus::classes {

// An upright square of half a ground cell's edge.
struct Column {
  uint64_t bins = 0;    // The heights above the ground that have points, a bit each.
  int32_t course = -1;  // Into Columns::courses; negative for what is no obstacle.
  float beside = 0;     // Obstacles around it, [0, 1].
  float along = 0;      // Near 1 where they stand in one line, else towards 0.
};

// Obstacles that touch each other.
struct Course {
  float columns = 0;
  float length_m = 0, width_m = 0;  // Four standard deviations.
  float top_m = 0;                  // Above the ground.
};

// The part of a column without a gap that a height lies in.
struct Stretch {
  float bottom_m = 0, top_m = 0;  // Above the ground.
  float bins = 0, above = 0;      // Bins with points in all of the column; above the run.
  float top_of_all_m = 0;         // Above the ground.
};

// Frame: z up. Immutable. Refers to the ground.
class Columns {
 public:
  Columns(std::span<const Eigen::Vector3f> points, const GroundGrid& ground);

  const Column& At(const Eigen::Vector3f& p) const;
  const Course* CourseAt(const Eigen::Vector3f& p) const;  // Null for what is in none.
  Stretch StretchAt(const Eigen::Vector3f& p) const;
  // Columns around it, itself included, that have points at its height, [1, 9].
  float BesideAtHeight(const Eigen::Vector3f& p) const;

 private:
  int BinOf(const Eigen::Vector3f& p) const;
  void FindCourses();
  void Follow(const Eigen::Vector2i& from);
  void LookBeside();

  const GroundGrid& ground_;
  Layout layout_;
  std::vector<Column> columns_;
  std::vector<Course> courses_;
};

}  // namespace isthmus::classes
