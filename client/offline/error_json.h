// Errors of a trajectory as JSON.
#pragma once

#include "client/console/json.h"
#include "client/evaluation/trajectory_error.h"

namespace isthmus::cli {

inline Json ToJson(const evaluation::ErrorStatistics& errors) {
  return {{"poses", errors.count},   {"rmse_m", errors.rmse_m},
          {"mean_m", errors.mean_m}, {"median_m", errors.median_m},
          {"max_m", errors.max_m},   {"rotation_rmse_deg", errors.rotation_rmse_deg}};
}

}  // namespace isthmus::cli
