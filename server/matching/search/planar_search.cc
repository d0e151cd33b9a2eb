#include "server/matching/search/planar_search.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "server/matching/search/fft_correlator.h"
#include "server/matching/search/limits.h"

namespace isthmus::matching {
namespace {

// Draws b's cells, turned, into the planes; returns the shift that field index (0, 0) stands for.
Eigen::Vector2d Draw(const BirdsEyeCells& cells, double yaw, const BirdsEyeImage& reference,
                     FftCorrelator* correlator) {
  const Eigen::Matrix2f R = Eigen::Rotation2Df(static_cast<float>(yaw)).toRotationMatrix();
  const Eigen::Vector2f corner = (R * cells.center).array() - cells.radius;
  const float inverse_cell = 1 / reference.cell_m;
  const auto index = [&](const Eigen::Vector2f& p) {
    const Eigen::Vector2f at = (R * p - corner) * inverse_cell;
    const int size = correlator->moved_size();
    return static_cast<size_t>(CellAt(at.y(), size)) * correlator->width() + CellAt(at.x(), size);
  };
  for (const auto& wall : cells.walls) {
    const size_t i = index(wall.position);
    const Eigen::Vector2f n = R * wall.normal;
    correlator->plane(BirdsEyeImage::kNormalX)[i] += n.x();
    correlator->plane(BirdsEyeImage::kNormalY)[i] += n.y();
    correlator->plane(BirdsEyeImage::kWall)[i] += wall.weight;
  }
  for (const auto& p : cells.free) correlator->plane(BirdsEyeImage::kFree)[index(p)] += 1.0f;
  return (reference.origin - corner).cast<double>();
}

// The part of an image that is not empty, and where its corner lies there.
struct Part {
  BirdsEyeImage image;
  int x = 0, y = 0;
};

Part NotEmpty(const BirdsEyeImage& image) {
  Eigen::AlignedBox2i box;
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const size_t i = static_cast<size_t>(y) * image.width + x;
      const bool is_empty =
          std::ranges::all_of(image.planes, [&](const auto& p) { return p[i] == 0; });
      if (!is_empty) box.extend(Eigen::Vector2i(x, y));
    }
  }
  if (box.isEmpty()) return {image, 0, 0};
  Part part;
  part.x = box.min().x();
  part.y = box.min().y();
  part.image.origin = image.origin;
  part.image.cell_m = image.cell_m;
  part.image.width = box.sizes().x() + 1;
  part.image.rows = box.sizes().y() + 1;
  for (int k = 0; k < BirdsEyeImage::kPlanes; ++k) {
    for (int y = part.y; y < part.y + part.image.rows; ++y) {
      const auto row =
          image.planes[k].begin() + static_cast<std::ptrdiff_t>(y) * image.width + part.x;
      part.image.planes[k].insert(part.image.planes[k].end(), row, row + part.image.width);
    }
  }
  return part;
}

// Local maxima of a field of scores that wraps round, best first.
std::vector<std::pair<float, int>> FindPeaks(const float* scores, int width, int rows) {
  std::vector<std::pair<float, int>> peaks;
  for (int y = 0; y < rows; ++y) {
    const float* row = scores + static_cast<size_t>(y) * width;
    const float* above = scores + static_cast<size_t>((y + rows - 1) % rows) * width;
    const float* below = scores + static_cast<size_t>((y + 1) % rows) * width;
    for (int x = 0; x < width; ++x) {
      const float s = row[x];
      if (!(s > 0) || (peaks.size() == kPeaksPerYaw && s <= peaks.back().first)) continue;
      const int left = x > 0 ? x - 1 : width - 1, right = x + 1 < width ? x + 1 : 0;
      if (row[left] > s || row[right] >= s || above[x] > s || below[x] >= s) continue;
      const auto place =
          std::lower_bound(peaks.begin(), peaks.end(), s,
                           [](const auto& p, float score) { return p.first > score; });
      peaks.insert(place, {s, y * width + x});
      if (peaks.size() > kPeaksPerYaw) peaks.pop_back();
    }
  }
  return peaks;
}

// Height of b's level frame over a's: the median difference of the ground both saw.
double GroundOffset(const GroundGrid& a, const GroundGrid& b, const PlanarPose& pose) {
  const Eigen::Matrix2f R = Eigen::Rotation2Df(static_cast<float>(pose.yaw)).toRotationMatrix();
  const Eigen::Vector2f t = pose.shift.cast<float>();
  std::vector<float> shared, filled;
  for (const GroundGrid::Sample& sample : b.seen()) {
    const Eigen::Vector2f p = R * sample.position + t;
    const float offset = a.Height(p.x(), p.y()) - sample.height;
    filled.push_back(offset);
    if (a.Seen(p.x(), p.y())) shared.push_back(offset);
  }
  std::vector<float>& offsets = shared.size() >= kMinSharedGroundCells ? shared : filled;
  if (offsets.empty()) return 0;
  std::nth_element(offsets.begin(), offsets.begin() + offsets.size() / 2, offsets.end());
  return offsets[offsets.size() / 2];
}

}  // namespace

std::vector<PlanarPose> SearchPlanar(const BirdsEyeImage& whole, const BirdsEyeCells& b,
                                     const PlanarSearchOptions& options) {
  // Transforms of the part are shorter; whitening depends on the image's size.
  const Part part = options.whiten ? Part{whole, 0, 0} : NotEmpty(whole);
  const BirdsEyeImage& reference = part.image;
  FftCorrelator correlator(reference, static_cast<int>(2 * b.radius / b.cell_m) + 2,
                           options.whiten);
  std::vector<PlanarPose> found;
  const int yaws = std::max(8, static_cast<int>(std::ceil(2 * M_PI / options.yaw_step_rad)));
  for (int k = 0; k < yaws && !options.stop.stop_requested(); ++k) {
    const double yaw = 2 * M_PI * k / yaws;
    const Eigen::Vector2d zero = Draw(b, yaw, whole, &correlator);
    const float* scores = correlator.Correlate();
    for (const auto& [score, i] : FindPeaks(scores, correlator.width(), correlator.rows())) {
      int x = i % correlator.width(), y = i / correlator.width();
      if (x >= reference.width) x -= correlator.width();
      if (y >= reference.rows) y -= correlator.rows();
      found.push_back(
          {yaw, zero + reference.cell_m * Eigen::Vector2d(part.x + x, part.y + y), score});
    }
  }
  return found;
}

Candidate ToCandidate(const WallMap& a, const WallMap& b, const PlanarPose& pose,
                      GuessSource source) {
  const double z = GroundOffset(a.ground(), b.ground(), pose);
  const Pose T_level_level = Pose::FromXyzRpy(pose.shift.x(), pose.shift.y(), z, 0, 0, pose.yaw);
  return {a.T_level_odom().Inverse() * T_level_level * b.T_level_odom(), pose.score, source};
}

}  // namespace isthmus::matching
