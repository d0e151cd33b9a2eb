#include "server/matching/registration/surface_sample.h"

#include <absl/container/flat_hash_set.h>

#include <algorithm>
#include <array>
#include <cstdint>

#include "server/matching/registration/voxel_key.h"

namespace isthmus::matching {
namespace {

// Every n-th so that `count` remain, spread over the whole.
void AppendEvenly(const std::vector<int>& from, size_t count, std::vector<int>* to) {
  for (size_t i = 0; i < count; ++i) to->push_back(from[i * from.size() / count]);
}

}  // namespace

std::vector<int> SampleBalanced(const std::vector<SurfacePoint>& points, double voxel_m,
                                size_t max_points) {
  const float inverse_voxel = static_cast<float>(1.0 / voxel_m);
  std::array<std::vector<int>, 3> classes;
  std::array<absl::flat_hash_set<uint64_t>, 3> taken;
  for (size_t i = 0; i < points.size(); ++i) {
    int axis = 0;
    points[i].normal.cwiseAbs().maxCoeff(&axis);
    if (taken[axis].insert(VoxelKey(points[i].position, inverse_voxel)).second) {
      classes[axis].push_back(static_cast<int>(i));
    }
  }
  std::sort(classes.begin(), classes.end(),
            [](const auto& x, const auto& y) { return x.size() < y.size(); });
  std::vector<int> sample;
  size_t room = max_points;
  for (size_t c = 0; c < classes.size(); ++c) {  // Small classes leave their room to larger ones.
    const size_t count = std::min(classes[c].size(), room / (classes.size() - c));
    AppendEvenly(classes[c], count, &sample);
    room -= count;
  }
  std::sort(sample.begin(), sample.end());
  return sample;
}

}  // namespace isthmus::matching
