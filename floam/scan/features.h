// Edge and surface features of a scan, after "F-LOAM" (Wang et al. 2021), section III-A.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/geometry/voxel_thinner.h"
#include "floam/rings/ring_scan.h"
#include "floam/scan/limits.h"
#include "floam/scan/neighbourhood.h"
#include "floam/scan/ring_chords.h"
#include "floam/scan/work.h"

namespace isthmus::floam {

struct FeatureOptions {
  int half_window = 5;  // Neighbours on each side on the ring, S of eq. 1.
  float range_noise_m = static_cast<float>(kRangeNoiseM);
  float edge_deviation_m = 0.07F;     // At least this far from the mean of the neighbours: an edge.
  float surface_deviation_m = 0.05F;  // At most this far: a surface.
  float surface_voxel_m = 0.4F;       // One surface feature per such voxel.
  float edge_voxel_m = 0.4F;          // One edge feature per such voxel.
  float map_voxel_m = 0.2F;           // One point per such voxel goes into the map.
  int max_surfaces = 1800;            // Matched per scan; a denser set is thinned evenly.
  int few_surfaces = 800;             // Fewer: the place is small, voxels become so (to a quarter).
  int sectors = 6;                    // Parts of a ring that edges are spread over.
  int edges_per_sector = 3;
  float pole_width_m = 0.6F;         // Wider than this along the ring a thing is no pole.
  int max_poles = 150;               // A denser set is thinned evenly.
  uint64_t max_work = kMaxScanWork;  // Steps that a scan may take, see Work.
};

// A point as it was measured, when, and how far it is to be trusted.
struct TimedPoint {
  Eigen::Vector3f position;  // Sensor frame at the instant of the measurement.
  float time = 0;            // Seconds relative to the END of the scan.
  float weight = 1;          // The paper's local weight, in (0, 1].
  uint16_t ring = 0;         // As in RingScan.

  // For state_codec.h.
  template <typename Self, typename Io>
  static void Fields(Self& self, Io& io) {
    io(self.position, self.time, self.weight, self.ring);
    if constexpr (Io::kIsReading) {
      io.Expect(self.position.allFinite() && std::abs(self.time) < 10 &&
                std::isfinite(self.weight));
    }
  }
};

struct Features {
  std::vector<TimedPoint> edges;
  std::vector<TimedPoint> surfaces;
  std::vector<RingChords> chords;  // Chords of `surfaces`; empty if they are not known.
  // The features that the map is made of: surface points that are denser than `surfaces`, and all
  // edges.
  std::vector<TimedPoint> map_surfaces;
  // Middles, ring by ring, of what is narrow and stands before what is behind it: posts, trunks,
  // legs. They tell the way on the level where there are no walls.
  std::vector<TimedPoint> poles;
  bool in_rings = true;  // Else TimedPoint::ring is that of a band, see RingScan.
  // Steps taken so far: choosing the features, and all matching of them.
  mutable Work work;

  // For state_codec.h. Chords and work are of use while a scan is matched, and not kept.
  template <typename Self, typename Io>
  static void Fields(Self& self, Io& io) {
    io(self.edges, self.surfaces, self.map_surfaces, self.poles, self.in_rings);
  }
};

// The smoothness of eq. 1, |sum over S of (p_i - p_j)| / (|S| |p_i|), of the middle one of the
// 2 * half_window + 1 points at `middle - half_window`.
float Smoothness(const RingPoint* middle, int half_window);

// Chooses features in time linear in the points. If there is little to see, in a small room, voxels
// are halved, and stay so for the scans after it until there are plenty. A point is a candidate
// only if the points next to it on the ring belong to the same surface (no occlusion, no gap) and
// that surface is not seen at grazing incidence; without rings, by what is around it on all sides
// (neighbourhood.h). Not thread safe: holds scratch memory.
class FeatureExtractor {
 public:
  explicit FeatureExtractor(const FeatureOptions& options);

  // Replaces the contents of `*out`, whose memory is reused. Points of zero range or with
  // coordinates that are not finite are never chosen. If that takes too much work, see
  // Features::work, it ends half done, and later scans are as if this one had not come.
  void Extract(const RingScan& scan, Features* out);

  // For state_codec.h.
  template <typename Self, typename Io>
  static void Fields(Self& self, Io& io) {
    float scale = self.scale_;
    io(scale);
    if constexpr (Io::kIsReading) {
      io.Expect(scale > 0.1F && scale <= 1);
      if (io.ok()) self.SetScale(scale);
    }
  }

 private:
  void SetScale(float scale);
  void ExtractAll(const RingScan& scan, Features* out);
  void ExtractWithoutRings(const RingScan& scan, Features* out);
  void Balance(std::vector<TimedPoint>* surfaces);
  void ExtractSegment(const RingPoint* begin, const RingPoint* end, Features* out);
  // The points [begin, end) of a ring belong together and stand before what is next to them.
  void AddPole(const RingPoint* begin, const RingPoint* end, Features* out) const;
  void KeepBestEdges(const RingPoint* ring_begin, const RingPoint* ring_end, Features* out);

  struct EdgeCandidate {
    const RingPoint* point;
    float smoothness;
  };

  const FeatureOptions options_;
  float scale_ = 1;  // Scale of the voxels.
  VoxelThinner surface_thinner_, edge_thinner_, map_thinner_;
  uint16_t ring_ = 0;                           // The one at hand.
  std::vector<EdgeCandidate> edge_candidates_;  // Candidates of that ring.
  Neighbourhoods neighbourhoods_;               // For a scan without rings.
  std::vector<uint8_t> facings_;                // Facings of its surfaces: see Facing.
};

}  // namespace isthmus::floam
