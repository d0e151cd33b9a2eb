// Files of true and estimated trajectories, as `eval` and `report` take them.
#pragma once

#include <absl/status/statusor.h>

#include <CLI/App.hpp>
#include <string>
#include <vector>

#include "client/evaluation/evaluation.h"

namespace isthmus::report {

struct EvaluationInput {
  std::vector<std::string> truths;     // One for each estimate, or one for all.
  std::vector<std::string> estimates;  // TUM or KITTI, as each is found to be.
  std::vector<std::string> times;      // For KITTI files: one for each estimate, or one for all.
  std::vector<std::string> names;      // The estimates'; none: those of the files.
  std::string align = "rigid", delta_unit = "m";
  double delta = 1;
  evaluation::EvaluationOptions options;
};

// --truth, --estimate, --times, --names, --merged, --align, --tolerance, --delta, --delta-unit.
// Neither truth nor estimate is required.
void AddEvaluationOptions(CLI::App& command, EvaluationInput& input);

// OK if the numbers of files fit. InvalidArgument, saying what is to be given, if not.
absl::Status CheckEvaluationInput(const EvaluationInput& input);

// The pairs to compare, for an input that is in order. Two KITTI files of as many poses need no
// times: then their poses belong together line by line, and their stamps count lines. Errors name
// the file.
absl::StatusOr<std::vector<evaluation::TrajectoryPair>> ReadEvaluationPairs(
    const EvaluationInput& input);

// True if all truths are KITTI files, whose y axis points down: seen from above they lie in x, z.
absl::StatusOr<bool> IsCameraFrame(const EvaluationInput& input);

// The options that the words stand for.
evaluation::EvaluationOptions OptionsOf(const EvaluationInput& input);

}  // namespace isthmus::report
