// OctoMap's own insertion of the scans that a map is made of, to compare ours with.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/map/composed_map.h"
#include "server/composition/occupancy/kept_occupancy.h"

namespace isthmus::bench {

struct OctomapJudgement {
  double ms = 0;  // CPU time of insertPointCloud for all scans.
  int64_t occupied = 0;
  int64_t differing = 0;  // Voxels that one of both has occupied and the other has not.
};

// OcTree::insertPointCloud, discretised, of each keyframe from where its sensor stood, in the order
// of the submaps; compared with the bytes of a .bt file of the same resolution.
OctomapJudgement JudgeByOctomap(const std::vector<PlacedSubmap>& submaps,
                                const SubmapReader& reader,
                                const composition::OccupancyOptions& options,
                                const std::string& file);

}  // namespace isthmus::bench
