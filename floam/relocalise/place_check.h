// A check whether a scan was taken at a certain place of the remembered map.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <unordered_set>
#include <vector>

#include "floam/map/local_map.h"
#include "floam/map/map_memory.h"
#include "floam/match/limits.h"
#include "floam/match/scan_matcher.h"
#include "floam/relocalise/limits.h"
#include "floam/scan/features.h"
#include "floam/scan/scan_frame.h"
#include "floam/scan/scan_image.h"

namespace isthmus::floam {

struct PlaceCheckOptions {
  double radius_m = kViewM;               // Radius of the surroundings that are compared.
  double kernel_start_m = kRoughKernelM;  // For a guess from above, cells of 0.4 m.
  double twist_sigma = 1.0;  // m/s and rad/s: how far the motion may be from the guess's.
  int max_blocks = 60'000;   // Blocks of the map to match to, see LocalMapOptions.
};

// The match of a scan at a place.
struct PlaceMatch {
  MatchResult match;
  double share = 0;  // Share of the surfaces nearby with a plane of the map at hand.
  WallsSeen walls;
};

// Matches scans to the remembered map instead of to the local one. Not thread safe.
class PlaceCheck {
 public:
  PlaceCheck(const MatchOptions& matching, const PlaceCheckOptions& options);

  // The scan that Check speaks of from now on. Keeps references; the image is of use for walls
  // only.
  void SetScan(const ScanFrame& frame, const ScanImage& image);

  // From a guess that may be off by half a metre and a few degrees (`is_rough`), or by little.
  // Without a look at the walls, which takes as long as the match, unless `with_walls`.
  PlaceMatch Check(const MapMemory& memory, const ScanPose& guess, bool is_rough,
                   bool with_walls = true);

  // The map's walls as a scan sees them from a place.
  WallsSeen Walls(const MapMemory& memory, const ScanImage& image, const Pose& T_map_sensor);

  // Forgets the map to match to, which fills as places are checked.
  void Clear();

  // For state_codec.h: of the map to match to. The order of tiles does not matter.
  template <typename Self, typename Io>
  static void Fields(Self& self, Io& io) {
    std::vector<uint64_t> filled(self.filled_.begin(), self.filled_.end());
    std::sort(filled.begin(), filled.end());
    io(self.surfaces_, filled);
    if constexpr (Io::kIsReading) self.filled_ = {filled.begin(), filled.end()};
  }

 private:
  void FillAround(const MapMemory& memory, const Eigen::Vector3d& position);

  const MatchOptions matching_;
  const PlaceCheckOptions options_;
  ScanMatcher matcher_;
  LocalMap surfaces_, edges_;            // No edges are remembered.
  std::unordered_set<uint64_t> filled_;  // Tiles.
  Features features_;                    // The scan's features nearby.
  const ScanImage* image_ = nullptr;
  std::vector<MapMemory::SeenPoint> points_;  // Scratch.
};

}  // namespace isthmus::floam
