// The page of a run: errors against the truth, with figures.
#pragma once

#include <absl/status/statusor.h>

#include <string>
#include <vector>

#include "client/evaluation/evaluation.h"
#include "client/report/figures.h"

namespace isthmus::report {

// `figures` were drawn in `folder`. Internal where one cannot be read.
absl::StatusOr<std::string> EvaluationPage(const evaluation::Evaluation& evaluation,
                                           const std::vector<Figure>& figures,
                                           const std::string& folder);

}  // namespace isthmus::report
