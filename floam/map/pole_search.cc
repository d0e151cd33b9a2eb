#include "floam/map/pole_search.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "floam/map/limits.h"

namespace isthmus::floam {
namespace {

// Distances to the nearest pole, over the level.
class PoleImage {
 public:
  explicit PoleImage(const std::vector<TimedPoint>& poles) : weight_(kSide * kSide) {
    for (const TimedPoint& pole : poles) {
      const Eigen::Vector2f at = pole.position.head<2>();
      const int x = Cell(at.x()), y = Cell(at.y());
      if (std::min(x, y) < kAround || std::max(x, y) >= kSide - kAround) continue;
      for (int i = x - kAround; i <= x + kAround; ++i) {
        for (int j = y - kAround; j <= y + kAround; ++j) {
          const float off2 = (Eigen::Vector2f(Middle(i), Middle(j)) - at).squaredNorm();
          const float ratio = 1 / (1 + off2 / (kKernelM * kKernelM));
          float& weight = weight_[i * kSide + j];
          weight = std::max(weight, ratio * ratio);
        }
      }
    }
  }

  float At(float x, float y) const {
    const int i = Cell(x), j = Cell(y);
    return std::min(i, j) < 0 || std::max(i, j) >= kSide ? 0 : weight_[i * kSide + j];
  }

 private:
  static constexpr int kSide = 800;  // Layout: cells, 60 m each way.
  // A pole counts as far as two kernels away: that is, for a 25th.
  static constexpr float kKernelM = static_cast<float>(kPoleStepM);
  static constexpr int kAround = 1 + static_cast<int>(2 * kKernelM / kPoleCellM);
  static int Cell(float v) { return static_cast<int>(std::floor(v / kPoleCellM)) + kSide / 2; }
  static float Middle(int cell) {
    return (static_cast<float>(cell - kSide / 2) + 0.5F) * kPoleCellM;
  }

  std::vector<float> weight_;
};

struct Move {
  float score = 0;
  double x = 0, y = 0, yaw = 0;
};

bool AreNear(const Move& a, const Move& b) {
  return std::hypot(a.x - b.x, a.y - b.y) < kSamePoleMotionM &&
         std::abs(a.yaw - b.yaw) < kSamePoleMotionRad;
}

}  // namespace

std::vector<Pose> MotionsOfPoles(const std::vector<TimedPoint>& before,
                                 const std::vector<TimedPoint>& now, double elapsed_s) {
  if (std::min(before.size(), now.size()) < kMinPoles) return {};
  const double reach_m = std::min(kFarthestPoleM, kFastestMPerS * elapsed_s);
  const double reach_rad = std::min(kFarthestPoleRad, kFastestRadPerS * elapsed_s);
  const PoleImage image(before);
  std::vector<Move> moves;
  std::vector<Eigen::Vector2f> turned(now.size());
  for (double yaw = -reach_rad; yaw <= reach_rad; yaw += kPoleStepRad) {
    const Eigen::Matrix2f R = Eigen::Rotation2Dd(yaw).toRotationMatrix().cast<float>();
    for (size_t k = 0; k < now.size(); ++k) turned[k] = R * now[k].position.head<2>();
    for (double x = -reach_m; x <= reach_m; x += kPoleStepM) {
      for (double y = -reach_m; y <= reach_m; y += kPoleStepM) {
        Move move{0, x, y, yaw};
        for (const Eigen::Vector2f& p : turned) {
          move.score += image.At(p.x() + static_cast<float>(x), p.y() + static_cast<float>(y));
        }
        moves.push_back(move);
      }
    }
  }
  std::sort(moves.begin(), moves.end(),
            [](const auto& a, const auto& b) { return a.score > b.score; });
  std::vector<Move> best;
  for (const Move& move : moves) {
    if (best.size() >= kMostMotions || move.score <= 0) break;
    const auto is_near = [&](const Move& other) { return AreNear(move, other); };
    if (std::none_of(best.begin(), best.end(), is_near)) best.push_back(move);
  }
  std::vector<Pose> motions;
  for (const Move& move : best) {
    motions.push_back(Pose::FromXyzRpy(move.x, move.y, 0, 0, 0, move.yaw));
  }
  return motions;
}

}  // namespace isthmus::floam
