#include "lab/bench/recordings/reference_cloud.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "core/codec/payload_layout.h"
#include "core/formats/pcd.h"

namespace isthmus::bench {
namespace {

// Points of ours that may lie between two of the reference: ten packets.
constexpr size_t kWindow = 4000;
// Points of the reference that must follow each other for the beginning to be found.
constexpr size_t kBeginning = 64;
// Points that follow one behind a gap; as many are never the same by chance.
constexpr size_t kFollowing = 8;

double RangeOf(const PointList& list, size_t i) {
  return std::hypot(list.x[i], list.y[i], list.z[i]);
}

bool IsSame(const PointList& a, size_t i, const PointList& b, size_t j, double tolerance_m) {
  return std::abs(RangeOf(a, i) - RangeOf(b, j)) <= tolerance_m &&
         std::abs(a.z[i] - b.z[j]) <= tolerance_m;
}

// The number of the reference's next points that follow each other in ours, too.
size_t Following(const PointList& reference, size_t i, const PointList& ours, size_t j,
                 double tolerance_m) {
  size_t hits = 0;
  while (hits < kFollowing && i + hits < reference.size() && j + hits < ours.size() &&
         IsSame(reference, i + hits, ours, j + hits, tolerance_m)) {
    ++hits;
  }
  return hits;
}

// The one of ours from `from` on, within the window, that is the reference's point i: the next one,
// else the first that the next points follow, too.
std::optional<size_t> Seek(const PointList& reference, size_t i, const PointList& ours, size_t from,
                           double tolerance_m) {
  const size_t end = std::min(from + kWindow, ours.size());
  if (from < end && IsSame(reference, i, ours, from, tolerance_m)) return from;
  std::optional<size_t> best;
  size_t best_hits = 0;
  for (size_t j = from; j < end && best_hits < kFollowing; ++j) {
    const size_t hits = Following(reference, i, ours, j, tolerance_m);
    if (hits <= best_hits) continue;
    best_hits = hits;
    best = j;
  }
  return best;
}

// The beginning of the reference in ours: most of its first points follow each other there.
size_t BeginningOf(const PointList& reference, const PointList& ours, double tolerance_m) {
  size_t best = 0, best_hits = 0;
  const size_t wanted = std::min(kBeginning, reference.size());
  for (size_t j = 0; j + wanted <= ours.size(); ++j) {
    size_t hits = 0;
    for (size_t i = 0; i < wanted && hits + 1 >= i / 2; ++i) {
      hits += IsSame(reference, i, ours, j + i, tolerance_m);
    }
    if (hits > best_hits) {
      best_hits = hits;
      best = j;
    }
  }
  return best;
}

double AzimuthBehind(const PointList& theirs, size_t i, const PointList& ours, size_t j) {
  const double cross = ours.x[j] * theirs.y[i] - ours.y[j] * theirs.x[i];
  const double dot = ours.x[j] * theirs.x[i] + ours.y[j] * theirs.y[i];
  return -std::atan2(cross, dot) * 180 / std::numbers::pi;
}

}  // namespace

absl::Status PointList::Append(const PointPayload& payload) {
  if (const absl::Status status = codec::CheckRawLayout(payload); !status.ok()) return status;
  std::vector<double>* columns[] = {&x, &y, &z, &rings};
  const PointField* fields[] = {codec::FindField(payload, {"x"}), codec::FindField(payload, {"y"}),
                                codec::FindField(payload, {"z"}),
                                codec::FindField(payload, {"ring", "channel"})};
  for (size_t i = 0; i < 4; ++i) {
    if (fields[i] == nullptr && i == 3) break;
    if (fields[i] == nullptr) return absl::InvalidArgumentError("a cloud has no x y z");
    const std::vector<double> values = codec::ReadColumn(payload, *fields[i]);
    columns[i]->insert(columns[i]->end(), values.begin(), values.end());
  }
  return absl::OkStatus();
}

absl::StatusOr<PointList> ReadReference(const std::string& path) {
  const absl::StatusOr<formats::PcdFile> file = formats::ReadPcd(path);
  if (!file.ok()) return file.status();
  PointList list;
  const absl::Status status = list.Append(file->payload);
  if (!status.ok()) return status;
  return list;
}

Agreement Compare(const PointList& reference, const PointList& ours, double tolerance_m) {
  Agreement agreement;
  agreement.reference_points = reference.size();
  size_t next = BeginningOf(reference, ours, tolerance_m);
  for (size_t i = 0; i < reference.size(); ++i) {
    const std::optional<size_t> j = Seek(reference, i, ours, next, tolerance_m);
    if (!j) {
      agreement.same_order = false;
      continue;
    }
    if (agreement.matched++ > 0) agreement.skipped += *j - next;
    next = *j + 1;
    agreement.distance.push_back(std::hypot(
        reference.x[i] - ours.x[*j], reference.y[i] - ours.y[*j], reference.z[i] - ours.z[*j]));
    agreement.range.push_back(std::abs(RangeOf(reference, i) - RangeOf(ours, *j)));
    agreement.height.push_back(std::abs(reference.z[i] - ours.z[*j]));
    const double azimuth = AzimuthBehind(reference, i, ours, *j);
    agreement.azimuth.push_back(azimuth);
    if (!ours.rings.empty()) {
      agreement.azimuth_of_ring[static_cast<int>(ours.rings[*j])].push_back(azimuth);
    }
    if (reference.rings.empty() || ours.rings.empty()) continue;
    ++agreement.rings_compared;
    agreement.rings_equal += reference.rings[i] == ours.rings[*j];
  }
  return agreement;
}

}  // namespace isthmus::bench
