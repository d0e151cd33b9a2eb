// The points of a Velodyne capture with the azimuths that TIER IV's nebula gives them.
#pragma once

#include <absl/status/statusor.h>

#include <string>

#include "client/readers/packets/velodyne/velodyne_model.h"
#include "lab/bench/recordings/reference_cloud.h"

namespace isthmus::bench {

// Nebula (its Vlp16Decoder and Vlp32Decoder of 2024) rounds azimuths to hundredths of a degree,
// does not interpolate in the last block of a packet, puts the second of two returns at the azimuth
// of the next firing, and lets the lasers of a VLP-32C fire one by one where the manual has pairs.
// Ours follow the manual; with nebula's azimuths, all else that we compute can be held against its
// clouds to the millimetre. The packets' model and calibration are the manual's unless given.
absl::StatusOr<PointList> ReadLikeNebula(const std::string& capture,
                                         const std::string& calibration);

}  // namespace isthmus::bench
