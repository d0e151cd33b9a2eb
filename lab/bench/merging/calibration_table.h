// Tables of claims: confidences and reasons beside the share of matches that were right.
#pragma once

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "lab/bench/merging/trial.h"

namespace isthmus::bench {

struct CalibrationBin {
  int count = 0, right = 0;
  double confidence = 0;  // Mean; 0 of nothing.
};

struct CalibrationFigures {
  std::array<CalibrationBin, 10> bins;  // [0, 0.1), ..., [0.9, 1].
  double brier = 0;                     // Mean squared difference of confidence and truth.
  // Expected calibration error (Naeini et al., "Obtaining Well Calibrated Probabilities Using
  // Bayesian Binning", AAAI 2015): mean over hypotheses of |share right - mean confidence| of
  // their bins.
  double ece = 0;
};

// Figures for confidences in [0, 1], each with whether the hypothesis was right.
CalibrationFigures Calibrate(const std::vector<std::pair<double, bool>>& hypotheses);

// Markdown: of the best hypothesis of every pair that has one, whatever became of it.
std::string CalibrationTable(const std::vector<Trial>& trials);

// Markdown: precision and recall, were all accepted from so much confidence on. Recall is of pairs
// that overlap by 0.3 and more.
std::string PrecisionTable(const std::vector<Trial>& trials);

// Markdown: of pairs that are not merged, how many have the right place as their best hypothesis,
// by reason and by whether they overlap by 0.3.
std::string ReasonTable(const std::vector<Trial>& trials);

// The three of them.
std::string ClaimTables(const std::vector<Trial>& trials);

}  // namespace isthmus::bench
