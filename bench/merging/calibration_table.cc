#include "bench/merging/calibration_table.h"

#include <absl/strings/str_format.h>

#include <algorithm>
#include <cmath>

namespace isthmus::bench {

CalibrationFigures Calibrate(const std::vector<std::pair<double, bool>>& hypotheses) {
  CalibrationFigures figures;
  const auto last = static_cast<int>(figures.bins.size()) - 1;
  for (const auto& [confidence, right] : hypotheses) {
    const auto index = std::clamp(static_cast<int>(std::floor(confidence * 10)), 0, last);
    CalibrationBin& bin = figures.bins[index];
    ++bin.count;
    bin.right += right ? 1 : 0;
    bin.confidence += confidence;
    const double difference = confidence - (right ? 1 : 0);
    figures.brier += difference * difference / static_cast<double>(hypotheses.size());
  }
  for (CalibrationBin& bin : figures.bins) {
    if (bin.count == 0) continue;
    figures.ece += std::abs(bin.right - bin.confidence) / static_cast<double>(hypotheses.size());
    bin.confidence /= bin.count;
  }
  return figures;
}

std::string CalibrationTable(const std::vector<Trial>& trials) {
  std::vector<std::pair<double, bool>> hypotheses;
  for (const Trial& trial : trials) {
    for (const PairResult& pair : trial.pairs) {
      if (pair.HasHypothesis()) {
        hypotheses.emplace_back(pair.match.confidence, pair.hypothesis_right);
      }
    }
  }
  const CalibrationFigures figures = Calibrate(hypotheses);
  std::string table =
      "| confidence | hypotheses | mean confidence | share right |\n|---|---|---|---|\n";
  double from = 0;
  for (const CalibrationBin& bin : figures.bins) {
    if (bin.count > 0) {
      absl::StrAppendFormat(&table, "| %.1f-%.1f | %d | %.2f | %.2f |\n", from, from + 0.1,
                            bin.count, bin.confidence, static_cast<double>(bin.right) / bin.count);
    }
    from += 0.1;
  }
  absl::StrAppendFormat(&table, "\nBrier score %.3f, expected calibration error %.3f\n",
                        figures.brier, figures.ece);
  return table;
}

}  // namespace isthmus::bench
