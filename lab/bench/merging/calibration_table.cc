#include "lab/bench/merging/calibration_table.h"

#include <absl/strings/str_format.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace isthmus::bench {
namespace {

constexpr double kOverlapping = 0.3;

bool IsFound(const PairResult& pair) {
  return pair.hypothesis_right || pair.outcome == TrialOutcome::kRight;
}

}  // namespace

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

std::string PrecisionTable(const std::vector<Trial>& trials) {
  std::string table =
      "| confidence from | hypotheses | right | precision | recall of overlaps from 0.3 |\n"
      "|---|---|---|---|---|\n";
  for (const double least : {0.3, 0.5, 0.7, 0.8, 0.9, 0.95, 0.97, 0.99}) {
    int count = 0, right = 0, overlapping = 0, recalled = 0;
    for (const Trial& trial : trials) {
      for (const PairResult& pair : trial.pairs) {
        const bool above = pair.HasHypothesis() && pair.match.confidence >= least;
        const bool is_right = above && IsFound(pair);
        count += above;
        right += is_right;
        overlapping += pair.overlap >= kOverlapping;
        recalled += is_right && pair.overlap >= kOverlapping;
      }
    }
    absl::StrAppendFormat(&table, "| %.2f | %d | %d | %.3f | %.2f |\n", least, count, right,
                          static_cast<double>(right) / std::max(1, count),
                          static_cast<double>(recalled) / std::max(1, overlapping));
  }
  return table;
}

std::string ReasonTable(const std::vector<Trial>& trials) {
  struct Counts {
    int overlapping = 0, found = 0, others = 0, others_found = 0;
  };
  std::map<std::string, Counts> reasons;
  for (const Trial& trial : trials) {
    for (const PairResult& pair : trial.pairs) {
      if (pair.match.state == MatchState::kAccepted) continue;
      Counts& counts = reasons[ToString(pair.match.reason)];
      const bool overlapping = pair.overlap >= kOverlapping;
      (overlapping ? counts.overlapping : counts.others) += 1;
      (overlapping ? counts.found : counts.others_found) += pair.HasHypothesis() && IsFound(pair);
    }
  }
  std::string table =
      "| reason | overlaps from 0.3 | of them right place found | others | of them right place "
      "found "
      "|\n|---|---|---|---|---|\n";
  for (const auto& [reason, counts] : reasons) {
    absl::StrAppendFormat(&table, "| %s | %d | %d | %d | %d |\n", reason, counts.overlapping,
                          counts.found, counts.others, counts.others_found);
  }
  return table;
}

std::string CalibrationTable(const std::vector<Trial>& trials) {
  std::vector<std::pair<double, bool>> hypotheses;
  for (const Trial& trial : trials) {
    for (const PairResult& pair : trial.pairs) {
      if (pair.HasHypothesis()) {
        hypotheses.emplace_back(pair.match.confidence, IsFound(pair));
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

std::string ClaimTables(const std::vector<Trial>& trials) {
  return CalibrationTable(trials) + "\n" + PrecisionTable(trials) + "\n" + ReasonTable(trials);
}

}  // namespace isthmus::bench
