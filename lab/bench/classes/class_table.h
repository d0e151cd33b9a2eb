// Counts of true and told classes, and the figures made of them.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/map/point_class.h"
#include "server/classes/classify.h"

namespace isthmus::bench {

struct ClassCounts {
  static constexpr size_t kBins = 10;  // Bins of probability.

  std::string world;
  std::array<std::array<uint64_t, kPointClasses>, kPointClasses> told = {};  // [truth][told].
  // Points whose class is known: dust and rain have none.
  std::array<uint64_t, kBins> points = {}, right = {};
  std::array<double, kBins> probability = {};  // Sums.
  double cpu_ms = 0;

  void Add(PointClass truth, const classes::PointLabel& label);
  void Add(const ClassCounts& other);
  uint64_t Total() const;
  // Intersection over union; negative for a class that is not there. Unknown counts as told
  // wrongly.
  double Iou(PointClass of) const;
  double F1(PointClass of) const;  // As for Iou.
};

// Markdown: by world, by class, told classes of the true ones, calibration.
std::string ClassTables(const std::vector<ClassCounts>& worlds);

}  // namespace isthmus::bench
