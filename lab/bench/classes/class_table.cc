#include "lab/bench/classes/class_table.h"

#include <absl/strings/str_format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace isthmus::bench {
namespace {

size_t NumberOf(PointClass of) { return static_cast<size_t>(of); }

// Classes that have more points than an odd one.
double MeanIou(const ClassCounts& counts, bool structure_only) {
  constexpr double kShare = 0.001;
  double sum = 0;
  int classes = 0;
  for (size_t i = 1; i < kPointClasses; ++i) {
    const auto of = static_cast<PointClass>(i);
    const bool is_structure = of == PointClass::kGround || of == PointClass::kCeiling ||
                              of == PointClass::kWall || of == PointClass::kPole;
    const auto& row = counts.told[i];
    const auto there = std::accumulate(row.begin(), row.end(), uint64_t{0});
    if (static_cast<double>(there) < kShare * static_cast<double>(counts.Total())) continue;
    if (structure_only && !is_structure) continue;
    sum += counts.Iou(of);
    ++classes;
  }
  return classes == 0 ? -1 : sum / classes;
}

double CalibrationError(const ClassCounts& counts) {
  double error = 0;
  for (size_t i = 0; i < ClassCounts::kBins; ++i) {
    error += std::abs(counts.probability[i] - static_cast<double>(counts.right[i]));
  }
  return error / static_cast<double>(counts.Total());
}

std::string Cell(double value) { return value < 0 ? " - |" : absl::StrFormat(" %.3f |", value); }

std::string WorldRow(const ClassCounts& counts) {
  std::string row = absl::StrFormat("| %s | %d |", counts.world, counts.Total());
  for (size_t i = 1; i < kPointClasses; ++i) row += Cell(counts.Iou(static_cast<PointClass>(i)));
  row += Cell(counts.F1(PointClass::kGround)) + Cell(MeanIou(counts, true)) +
         Cell(MeanIou(counts, false)) + Cell(CalibrationError(counts));
  return row +
         absl::StrFormat(" %.2f |\n", 1e3 * counts.cpu_ms / static_cast<double>(counts.Total()));
}

std::string Heading(const std::string& first, size_t columns) {
  std::string heading = "| " + first + " |", line = "\n|---|";
  for (size_t i = kPointClasses - columns; i < kPointClasses; ++i) {
    heading += absl::StrFormat(" %s |", ToString(static_cast<PointClass>(i)));
    line += "---|";
  }
  return heading + line;
}

}  // namespace

void ClassCounts::Add(PointClass truth, const classes::PointLabel& label) {
  ++told[NumberOf(truth)][NumberOf(label.of)];
  if (truth == PointClass::kUnknown) return;
  const size_t bin = std::min(static_cast<size_t>(label.probability * kBins), kBins - 1);
  ++points[bin];
  probability[bin] += label.probability;
  right[bin] += truth == label.likeliest ? 1 : 0;
}

void ClassCounts::Add(const ClassCounts& other) {
  for (size_t i = 0; i < kPointClasses; ++i) {
    for (size_t k = 0; k < kPointClasses; ++k) told[i][k] += other.told[i][k];
  }
  for (size_t i = 0; i < kBins; ++i) {
    points[i] += other.points[i];
    right[i] += other.right[i];
    probability[i] += other.probability[i];
  }
  cpu_ms += other.cpu_ms;
}

uint64_t ClassCounts::Total() const {
  return std::accumulate(points.begin(), points.end(), uint64_t{0});
}

double ClassCounts::Iou(PointClass of) const {
  uint64_t is = 0, said = 0;
  for (size_t i = 0; i < kPointClasses; ++i) {
    is += told[NumberOf(of)][i];
    said += told[i][NumberOf(of)];
  }
  if (is == 0) return -1;
  const uint64_t both = told[NumberOf(of)][NumberOf(of)];
  return static_cast<double>(both) / static_cast<double>(is + said - both);
}

double ClassCounts::F1(PointClass of) const {
  const double iou = Iou(of);
  return iou < 0 ? -1 : 2 * iou / (1 + iou);
}

std::string ClassTables(const std::vector<ClassCounts>& worlds) {
  std::string text = "| world | points |";
  for (size_t i = 1; i < kPointClasses; ++i) {
    text += absl::StrFormat(" %s |", ToString(static_cast<PointClass>(i)));
  }
  text += " ground F1 | structure | all | calibration | us a point |\n|---|---|";
  for (size_t i = 1; i < kPointClasses + 5; ++i) text += "---|";
  text += "\n";
  ClassCounts sum;
  sum.world = "all";
  for (const ClassCounts& counts : worlds) {
    text += WorldRow(counts);
    sum.Add(counts);
  }
  text += WorldRow(sum) + "\n" + Heading("is, told as", kPointClasses) + "\n";
  for (size_t i = 1; i < kPointClasses; ++i) {
    const double there =
        static_cast<double>(std::accumulate(sum.told[i].begin(), sum.told[i].end(), uint64_t{0}));
    text += absl::StrFormat("| %s |", ToString(static_cast<PointClass>(i)));
    for (const uint64_t told : sum.told[i]) {
      text += absl::StrFormat(" %.3f |", static_cast<double>(told) / std::max(there, 1.0));
    }
    text += "\n";
  }
  text += "\n| probability | points | right |\n|---|---|---|\n";
  for (size_t i = 0; i < ClassCounts::kBins; ++i) {
    if (sum.points[i] == 0) continue;
    const auto points = static_cast<double>(sum.points[i]);
    text += absl::StrFormat("| %.2f | %d | %.3f |\n", sum.probability[i] / points, sum.points[i],
                            static_cast<double>(sum.right[i]) / points);
  }
  return text;
}

}  // namespace isthmus::bench
