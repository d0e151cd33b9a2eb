// The floors that robots drove on, told by the heights at which their sensors were.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/map/trajectory.h"

namespace isthmus::floors {

// The places of sensors on one floor, map frame. A floor may slope: it is as high as the nearest
// station.
struct Floor {
  std::vector<Eigen::Vector3d> stations;
  double lowest_m = 0, highest_m = 0;  // Heights of the stations.
};

// Appends the sensor's places along a way, at least kStationM apart. Map frame.
void AddStations(const Trajectory& way, std::vector<Eigen::Vector3d>* stations);

// The lowest first. Heights at which little was driven (stairs, lifts) part floors; their stations
// belong to none. Never empty where there are stations: then all are of one floor.
std::vector<Floor> FloorsOf(const std::vector<Eigen::Vector3d>& stations);

}  // namespace isthmus::floors
