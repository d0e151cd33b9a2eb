#include "floam/state/options_checksum.h"

#include "core/state_codec.h"

namespace isthmus::floam {
namespace {

void Add(const SensorModel& sensor, StateWriter& io) {
  io(sensor.name, sensor.spins, sensor.rings, sensor.elevations, sensor.scan_period_s,
     sensor.min_range_m, sensor.max_range_m, sensor.start_azimuth, sensor.clockwise,
     sensor.sorted_files);
}

void Add(const FeatureOptions& features, StateWriter& io) {
  io(features.half_window, features.range_noise_m, features.edge_deviation_m,
     features.surface_deviation_m, features.surface_voxel_m, features.edge_voxel_m,
     features.map_voxel_m, features.max_surfaces, features.few_surfaces, features.sectors,
     features.edges_per_sector, features.pole_width_m, features.max_poles);
}

void Add(const LocalMapOptions& map, StateWriter& io) {
  io(map.radius_m, map.lasting_radius_m, map.lasting_scans, map.max_blocks, map.max_count);
}

void Add(const MatchOptions& matching, StateWriter& io) {
  io(matching.max_iterations, matching.pose_only_iterations, matching.point_noise_m,
     matching.pole_noise_m, matching.kernel_start_m, matching.kernel_m, matching.gate_m,
     matching.stop_m, matching.stop_rad, matching.free_sigma_m, matching.free_sigma_rad,
     matching.stride);
}

}  // namespace

uint64_t OptionsChecksum(const SensorModel& sensor, const OdometryOptions& options) {
  StateWriter io;
  Add(sensor, io);
  Add(options.features, io);
  Add(options.map, io);
  Add(options.matching, io);
  io(options.mode, options.speed_change_sigma, options.yaw_rate_change_sigma,
     options.tilt_rate_sigma, options.min_used_share, options.min_used, options.min_agreement,
     options.max_surprise_m, options.max_surprise_rad, options.map_distance_m,
     options.map_angle_rad, options.map_first_scans, options.map_young_distance_m,
     options.R_base_sensor.coeffs());
  const std::string bytes = io.Take();
  return StateChecksum(bytes.data(), bytes.size());
}

}  // namespace isthmus::floam
