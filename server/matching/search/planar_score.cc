#include "server/matching/search/planar_score.h"

#include <cmath>

namespace isthmus::matching {

PlanarScore::PlanarScore(const BirdsEyeImage& reference, const BirdsEyeCells& moved,
                         size_t free_stride)
    : reference_(reference), moved_(moved), free_stride_(free_stride) {
  const auto& planes = reference.planes;
  walls_.reserve(planes[BirdsEyeImage::kWall].size());
  for (size_t i = 0; i < planes[BirdsEyeImage::kWall].size(); ++i) {
    walls_.emplace_back(planes[BirdsEyeImage::kNormalX][i], planes[BirdsEyeImage::kNormalY][i],
                        planes[BirdsEyeImage::kWall][i]);
  }
}

double PlanarScore::Of(const PlanarPose& pose, double least) const {
  const float c = static_cast<float>(std::cos(pose.yaw)),
              s = static_cast<float>(std::sin(pose.yaw));
  const float inverse_cell = 1 / reference_.cell_m;
  const float ox = (static_cast<float>(pose.shift.x()) - reference_.origin.x()) * inverse_cell;
  const float oy = (static_cast<float>(pose.shift.y()) - reference_.origin.y()) * inverse_cell;
  const auto index = [&](const Eigen::Vector2f& p) -> int {
    const float x = (c * p.x() - s * p.y()) * inverse_cell + ox;
    const float y = (s * p.x() + c * p.y()) * inverse_cell + oy;
    if (!(x >= 0 && y >= 0)) return -1;
    const int column = static_cast<int>(x), row = static_cast<int>(y);
    if (column >= reference_.width || row >= reference_.rows) return -1;
    return row * reference_.width + column;
  };
  double score = 0;
  for (const auto& wall : moved_.walls) {
    const int i = index(wall.position);
    if (i < 0) continue;
    const Eigen::Vector2f& n = wall.normal;
    score += walls_[i].x() * (c * n.x() - s * n.y()) + walls_[i].y() * (s * n.x() + c * n.y()) +
             walls_[i].z() * wall.weight;
  }
  const std::vector<float>& free = reference_.planes[BirdsEyeImage::kFree];
  const auto stride = static_cast<double>(free_stride_);
  double conflict = 0;
  for (size_t k = 0; k < moved_.free.size() && score + stride * conflict > least;
       k += free_stride_) {
    const int i = index(moved_.free[k]);
    if (i >= 0) conflict += free[i];
  }
  return score + stride * conflict;
}

}  // namespace isthmus::matching
