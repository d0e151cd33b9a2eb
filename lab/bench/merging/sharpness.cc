#include "lab/bench/merging/sharpness.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <unordered_map>

#include "lab/bench/merging/aligned_again.h"
#include "lab/bench/summary.h"

namespace isthmus::bench {
namespace {

constexpr double kPieceM = 0.5;
constexpr size_t kOneIn = 4;          // Points that are looked at.
constexpr size_t kFewestPoints = 12;  // A piece has so many; a shared one, of either robot.
// Standard deviations of a piece in truth: across it at most, and along it at least.
constexpr double kFlatM = 0.04, kWideM = 0.1;
constexpr double kOneInTwenty = 0.95;

struct Moments {
  size_t count = 0;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();

  void Add(const Eigen::Vector3d& p) {
    ++count;
    sum += p;
    squares += p * p.transpose();
  }
  Eigen::Vector3d Mean() const { return sum / static_cast<double>(count); }
  // Variances ascending, with their directions.
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> Axes() const {
    const Eigen::Vector3d mean = Mean();
    return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(squares / static_cast<double>(count) -
                                                          mean * mean.transpose());
  }
};

// The points of one cell of the true world, as some poses have them.
struct Piece {
  Moments all, of_first, of_second;
};

// Submaps with their robots, and a cell for each of their points that is looked at.
class Pieces {
 public:
  Pieces(const std::vector<MappedSubmap>& submaps, const std::vector<Pose>& truth)
      : submaps_(submaps) {
    std::unordered_map<uint64_t, size_t> numbers;
    std::vector<size_t> first_submap;
    for (size_t s = 0; s < submaps.size(); ++s) {
      const auto& points = submaps[s].submap->points;
      for (size_t i = 0; i < points.size(); i += kOneIn) {
        const Eigen::Vector3d p = truth[s] * points[i].Position().cast<double>().eval();
        const size_t cell = numbers.try_emplace(CellOf(p), numbers.size()).first->second;
        if (cell == first_submap.size()) {
          first_submap.push_back(s);
          twice_.push_back(false);
        }
        twice_[cell] = twice_[cell] || first_submap[cell] != s;
        cells_.push_back(cell);
      }
    }
    const std::vector<Piece> in_truth = Lay(truth);
    for (size_t cell = 0; cell < in_truth.size(); ++cell) {
      if (twice_[cell]) twice_[cell] = IsFlat(in_truth[cell].all);
      pieces_ += twice_[cell];
      shared_ += twice_[cell] && IsShared(in_truth[cell]);
    }
  }

  size_t pieces() const { return pieces_; }
  size_t shared() const { return shared_; }

  Sharpness Measure(const std::vector<Pose>& poses) const {
    const std::vector<Piece> laid = Lay(poses);
    std::vector<double> thickness, apart;
    for (size_t cell = 0; cell < laid.size(); ++cell) {
      if (!twice_[cell]) continue;
      const auto axes = laid[cell].all.Axes();
      thickness.push_back(std::sqrt(std::max(0.0, axes.eigenvalues()[0])));
      if (!IsShared(laid[cell])) continue;
      const Eigen::Vector3d between = laid[cell].of_first.Mean() - laid[cell].of_second.Mean();
      apart.push_back(std::abs(axes.eigenvectors().col(0).dot(between)));
    }
    return {Percentile(thickness, 0.5), Percentile(thickness, kOneInTwenty), Percentile(apart, 0.5),
            Percentile(apart, kOneInTwenty)};
  }

 private:
  static uint64_t CellOf(const Eigen::Vector3d& p) {
    uint64_t key = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const auto cell = static_cast<int64_t>(std::floor(p[axis] / kPieceM));
      key = (key << 20) | (static_cast<uint64_t>(cell) & 0xFFFFF);
    }
    return key;
  }

  static bool IsFlat(const Moments& moments) {
    if (moments.count < kFewestPoints) return false;
    const auto axes = moments.Axes();
    return axes.eigenvalues()[0] <= kFlatM * kFlatM && axes.eigenvalues()[1] >= kWideM * kWideM;
  }

  static bool IsShared(const Piece& piece) {
    return std::min(piece.of_first.count, piece.of_second.count) >= kFewestPoints;
  }

  // By cell. About the first submap, as squares of large numbers lose digits.
  std::vector<Piece> Lay(const std::vector<Pose>& poses) const {
    std::vector<Piece> laid(twice_.size());
    const Eigen::Vector3d origin = poses.front().translation();
    size_t next = 0;
    for (size_t s = 0; s < submaps_.size(); ++s) {
      const auto& points = submaps_[s].submap->points;
      for (size_t i = 0; i < points.size(); i += kOneIn) {
        const Eigen::Vector3d p = poses[s] * points[i].Position().cast<double>().eval() - origin;
        Piece& piece = laid[cells_[next++]];
        piece.all.Add(p);
        if (submaps_[s].robot == 0) piece.of_first.Add(p);
        if (submaps_[s].robot == 1) piece.of_second.Add(p);
      }
    }
    return laid;
  }

  const std::vector<MappedSubmap>& submaps_;
  std::vector<size_t> cells_;  // The points', in order of submaps.
  std::vector<bool> twice_;    // By cell: it is a piece.
  size_t pieces_ = 0, shared_ = 0;
};

}  // namespace

SharpnessFigures MeasureSharpness(const std::vector<DrivenRobot>& robots,
                                  server::Pipeline& pipeline) {
  const auto listed = pipeline.reader().ListSubmaps(std::nullopt);
  if (!listed.ok()) return {};
  std::map<SubmapId, Pose> in_map;
  for (const SubmapStatus& submap : *listed) {
    if (submap.component) in_map[submap.info.id] = submap.T_map_submap;
  }
  std::vector<MappedSubmap> submaps;
  std::vector<Pose> truth, placed;
  for (size_t r = 0; r < robots.size(); ++r) {
    for (const auto& submap : robots[r].submaps) {
      const auto it = in_map.find(submap->id);
      if (it == in_map.end()) continue;
      submaps.push_back({r, submap});
      truth.push_back(robots[r].FindPose(submap->keyframes.front().sequence)->T_world_sensor);
      placed.push_back(it->second);
    }
  }
  if (submaps.empty()) return {};
  const Pieces pieces(submaps, truth);
  return {pieces.pieces(), pieces.shared(), pieces.Measure(truth), pieces.Measure(placed),
          pieces.Measure(AlignAgain(submaps, placed))};
}

std::string SharpnessTable(const std::vector<MapSharpness>& maps) {
  std::string rows;
  for (const auto& [map, seed, figures] : maps) {
    if (figures.pieces == 0) continue;
    absl::StrAppendFormat(&rows, "| %s | %d | %d (%d) ", map, seed, figures.pieces, figures.shared);
    const Sharpness* const all[] = {&figures.in_truth, &figures.in_map, &figures.aligned_again};
    for (const Sharpness* s : all) {
      absl::StrAppendFormat(&rows, "| %.1f (%.1f) ", 1e3 * s->thickness_m, 1e3 * s->thick_m);
    }
    for (const Sharpness* s : all) {
      absl::StrAppendFormat(&rows, "| %.1f (%.1f) ", 1e3 * s->apart_m, 1e3 * s->far_apart_m);
    }
    absl::StrAppend(&rows, "|\n");
  }
  if (rows.empty()) return rows;
  return absl::StrCat(
      "| map | seed | pieces (of two robots) | walls in truth mm (one in twenty) | in the map mm | "
      "aligned again mm | robots apart in truth mm | in the map mm | aligned again mm |\n"
      "|---|---|---|---|---|---|---|---|---|\n",
      rows);
}

nlohmann::ordered_json ToJson(const SharpnessFigures& figures) {
  const auto to_json = [](const Sharpness& s) -> nlohmann::ordered_json {
    return {{"thickness_m", s.thickness_m},
            {"thick_m", s.thick_m},
            {"apart_m", s.apart_m},
            {"far_apart_m", s.far_apart_m}};
  };
  return {{"pieces", figures.pieces},
          {"shared", figures.shared},
          {"in_truth", to_json(figures.in_truth)},
          {"in_map", to_json(figures.in_map)},
          {"aligned_again", to_json(figures.aligned_again)}};
}

}  // namespace isthmus::bench
