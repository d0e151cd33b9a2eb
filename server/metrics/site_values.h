// The values of one site, read from its pipeline.
#pragma once

#include <string>

#include "server/metrics/robot_names.h"
#include "server/pipeline.h"

namespace isthmus::metrics {

class Values;

void AddSite(const std::string& site, server::Pipeline& pipeline, RobotNames* robots,
             Values* values);

}  // namespace isthmus::metrics
