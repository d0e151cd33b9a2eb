#include "server/matching/search/place_descriptor.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace isthmus::matching {
namespace {

using Cells = std::array<float, static_cast<size_t>(kPlaceRings) * kPlaceSectors>;

// The greatest height per cell, as a share of the band; 0 where there is nothing.
Cells Rasterise(const std::vector<Eigen::Vector3f>& points, const PlaceDescriptorOptions& options) {
  Cells cells = {};
  const float max_range = static_cast<float>(options.max_range_m);
  const float band = options.high_m - options.low_m;
  for (const Eigen::Vector3f& point : points) {
    if (!(point.z() > options.low_m && point.z() <= options.high_m)) continue;
    const float range = point.head<2>().norm();
    if (!(range < max_range)) continue;
    const float turn = std::atan2(point.y(), point.x()) / (2 * std::numbers::pi_v<float>)+0.5f;
    const int sector = std::min(static_cast<int>(turn * kPlaceSectors), kPlaceSectors - 1);
    const int ring = std::min(static_cast<int>(range / max_range * kPlaceRings), kPlaceRings - 1);
    float& cell = cells[sector * kPlaceRings + ring];
    cell = std::max(cell, (point.z() - options.low_m) / band);
  }
  return cells;
}

Cells Blur(const Cells& cells) {
  Cells along = {}, blurred = {};
  for (int sector = 0; sector < kPlaceSectors; ++sector) {
    const float* in = &cells[sector * kPlaceRings];
    float* out = &along[sector * kPlaceRings];
    for (int ring = 0; ring < kPlaceRings; ++ring) {
      const float inner = ring > 0 ? in[ring - 1] : 0,
                  outer = ring + 1 < kPlaceRings ? in[ring + 1] : 0;
      out[ring] = 0.5f * in[ring] + 0.25f * (inner + outer);
    }
  }
  for (int sector = 0; sector < kPlaceSectors; ++sector) {
    const float* middle = &along[sector * kPlaceRings];
    const float* left = &along[(sector + kPlaceSectors - 1) % kPlaceSectors * kPlaceRings];
    const float* right = &along[(sector + 1) % kPlaceSectors * kPlaceRings];
    for (int ring = 0; ring < kPlaceRings; ++ring) {
      blurred[sector * kPlaceRings + ring] =
          0.5f * middle[ring] + 0.25f * (left[ring] + right[ring]);
    }
  }
  return blurred;
}

// To unit length, where a cell's square counts by its area.
void WeighCells(Cells* cells) {
  double sum = 0;
  for (int i = 0; i < kPlaceRings * kPlaceSectors; ++i) {
    (*cells)[i] *= std::sqrt(static_cast<float>(i % kPlaceRings) + 0.5f);
    sum += (*cells)[i] * (*cells)[i];
  }
  if (!(sum > 0)) return;
  const float scale = static_cast<float>(1 / std::sqrt(sum));
  for (float& cell : *cells) cell *= scale;
}

float Dot(const float* a, const float* b, int count) {
  using Vector = Eigen::Map<const Eigen::VectorXf>;
  return Vector(a, count).dot(Vector(b, count));
}

float KeyDistance2(const PlaceDescriptor& a, const PlaceDescriptor& b) {
  float sum = 0;
  for (int ring = 0; ring < kPlaceRings; ++ring) {
    const float difference = a.ring_key[ring] - b.ring_key[ring];
    sum += difference * difference;
  }
  return sum;
}

// Indices of the places whose ring keys are nearest, nearest first.
std::vector<size_t> Shortlist(const PlaceDescriptor& query,
                              const std::vector<PlaceDescriptor>& places, size_t count) {
  std::vector<std::pair<float, size_t>> ranked;
  ranked.reserve(places.size());
  for (size_t i = 0; i < places.size(); ++i) {
    if (!places[i].empty()) ranked.emplace_back(KeyDistance2(query, places[i]), i);
  }
  count = std::min(count, ranked.size());
  std::partial_sort(ranked.begin(), ranked.begin() + static_cast<std::ptrdiff_t>(count),
                    ranked.end());
  std::vector<size_t> shortlist;
  shortlist.reserve(count);
  for (size_t i = 0; i < count; ++i) shortlist.push_back(ranked[i].second);
  return shortlist;
}

}  // namespace

bool PlaceDescriptor::empty() const {
  return std::none_of(ring_key.begin(), ring_key.end(), [](float key) { return key > 0; });
}

PlaceDescriptor DescribePlace(const std::vector<Eigen::Vector3f>& points,
                              const PlaceDescriptorOptions& options) {
  PlaceDescriptor descriptor;
  descriptor.cells = Rasterise(points, options);
  // About a ring, and a sector, to either side.
  descriptor.cells = Blur(Blur(descriptor.cells));
  for (int i = 0; i < kPlaceRings * kPlaceSectors; ++i) {
    descriptor.ring_key[i % kPlaceRings] += descriptor.cells[i] / kPlaceSectors;
  }
  WeighCells(&descriptor.cells);
  return descriptor;
}

PlaceComparison Compare(const PlaceDescriptor& a, const PlaceDescriptor& b) {
  int best_turn = 0;
  float best = 0;
  for (int turn = 0; turn < kPlaceSectors; ++turn) {
    // Sector s of b lies on sector s + turn of a.
    const int split = turn * kPlaceRings, rest = kPlaceRings * kPlaceSectors - split;
    const float agreement = Dot(&a.cells[split], b.cells.data(), rest) +
                            Dot(a.cells.data(), &b.cells[rest % b.cells.size()], split);
    if (agreement > best) {
      best = agreement;
      best_turn = turn;
    }
  }
  PlaceComparison comparison;
  comparison.distance = std::clamp(1.0 - best, 0.0, 1.0);
  // (-pi, pi].
  const int turn = best_turn > kPlaceSectors / 2 ? best_turn - kPlaceSectors : best_turn;
  comparison.yaw = turn * 2 * std::numbers::pi / kPlaceSectors;
  return comparison;
}

std::vector<PlaceHit> FindPlaces(const PlaceDescriptor& query,
                                 const std::vector<PlaceDescriptor>& places, size_t k) {
  if (query.empty()) return {};
  k = std::min(k, places.size());
  std::vector<PlaceHit> hits;
  for (const size_t place :
       Shortlist(query, places, std::max(kMinShortlist, kShortlistPerHit * k))) {
    hits.push_back({place, Compare(query, places[place])});
  }
  std::sort(hits.begin(), hits.end(), [](const PlaceHit& a, const PlaceHit& b) {
    return std::pair(a.comparison.distance, a.place) < std::pair(b.comparison.distance, b.place);
  });
  if (hits.size() > k) hits.resize(k);
  return hits;
}

}  // namespace isthmus::matching
