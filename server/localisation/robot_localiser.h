// A robot that is followed in the map as it is placed now.
#pragma once

#include <absl/status/statusor.h>

#include <atomic>
#include <memory>

#include "core/concurrency/executor.h"
#include "core/records/localisation.h"
#include "floam/odometry_options.h"
#include "floam/rings/sensor_model.h"
#include "server/localisation/localisation_maps.h"
#include "server/localisation/localising_robots.h"
#include "server/pipeline.h"

namespace isthmus::localisation {

// Its scans are dealt with by the executor's threads, beside those of robots that map, so that
// robots together take no more of the machine than these. It is among `robots` while it lives.
// Everything must outlive it. Errors of LocalisationMaps::Get.
absl::StatusOr<std::unique_ptr<server::RobotLocaliser>> MakeRobotLocaliser(
    const floam::SensorModel& sensor, const floam::OdometryOptions& options,
    const LocalisationRequest& request, LocalisationMaps* maps, LocalisingRobots* robots,
    Executor* executor, const std::atomic<bool>* shut_down);

}  // namespace isthmus::localisation
