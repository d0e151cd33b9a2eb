// Errors of a trajectory as JSON.
#pragma once

#include "client/console/json.h"
#include "client/evaluation/trajectory_error.h"

namespace isthmus::cli {

inline Json ToJson(const evaluation::ErrorStatistics& errors) {
  return {{"poses", errors.count},
          {"rmse_m", errors.rmse_m},
          {"mean_m", errors.mean_m},
          {"median_m", errors.median_m},
          {"std_m", errors.std_m},
          {"min_m", errors.min_m},
          {"max_m", errors.max_m},
          {"rotation_rmse_deg", errors.rotation_deg.rmse},
          {"rotation_mean_deg", errors.rotation_deg.mean},
          {"rotation_median_deg", errors.rotation_deg.median},
          {"rotation_std_deg", errors.rotation_deg.std},
          {"rotation_max_deg", errors.rotation_deg.max}};
}

}  // namespace isthmus::cli
