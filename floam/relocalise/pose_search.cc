#include "floam/relocalise/pose_search.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <queue>

#include "floam/relocalise/limits.h"

namespace isthmus::floam {
namespace {

constexpr int kTopLevel = 3;  // Layout: blocks of 8 x 8 cells are looked at first.

// A square of 2^level cells, by its low corner, at one heading.
struct PoseBlock {
  int32_t bound = 0;  // No pose in it scores more.
  uint16_t heading = 0;
  int16_t x = 0, y = 0;
  int8_t level = 0;

  // The best first, and of equals the smallest: it is nearer to a pose.
  bool operator<(const PoseBlock& other) const {
    return bound != other.bound ? bound < other.bound : level > other.level;
  }
};

class Search {
 public:
  Search(const WallImage& image, const std::vector<Eigen::Vector2f>& walls,
         const PoseSearchOptions& options)
      : image_(image),
        options_(options),
        pyramid_(image, kTopLevel + 1),
        points_(walls.size()),
        least_(static_cast<int32_t>(
            std::ceil(options.min_score * WallImage::kWall * static_cast<double>(points_)))) {
    const double step = HeadingStep(walls);
    headings_ = static_cast<int>(std::ceil(2 * std::numbers::pi / step));
    offsets_.reserve(headings_ * points_);
    for (int k = 0; k < headings_; ++k) {
      for (const Eigen::Vector2i& offset : WallOffsets(walls, YawOf(k))) {
        offsets_.push_back(offset.y() * image.width + offset.x());
      }
    }
  }

  PoseSearchResult Run() {
    AddTopBlocks();
    while (!queue_.empty() && static_cast<int>(result_.found.size()) < options_.max_found) {
      if (result_.lookups > options_.max_lookups) return result_;
      const PoseBlock block = queue_.top();
      queue_.pop();
      if (block.bound < least_) break;
      if (block.level == 0) {
        KeepBlock(block);
      } else {
        Split(block);
      }
    }
    result_.complete = true;
    return result_;
  }

 private:
  double YawOf(int heading) const {
    return 2 * std::numbers::pi * heading / headings_ - std::numbers::pi;
  }

  // True if the sensor may be anywhere in the block.
  bool IsStandable(int x, int y, int level) const {
    const int end_x = std::min(x + (1 << level), image_.width);
    const int end_y = std::min(y + (1 << level), image_.width);
    for (int cy = y; cy < end_y; ++cy) {
      const uint8_t* row = image_.standable.data() + static_cast<size_t>(cy) * image_.width;
      if (std::find(row + x, row + end_x, 1) != row + end_x) return true;
    }
    return false;
  }

  void Push(int heading, int x, int y, int level) {
    const int8_t* at = pyramid_.Level(level) + static_cast<size_t>(y) * image_.width + x;
    const int32_t* offset = offsets_.data() + heading * points_;
    int32_t bound = 0;
    for (size_t k = 0; k < points_; ++k) bound += at[offset[k]];
    result_.lookups += points_;
    if (bound < least_) return;
    queue_.push({bound, static_cast<uint16_t>(heading), static_cast<int16_t>(x),
                 static_cast<int16_t>(y), static_cast<int8_t>(level)});
  }

  void AddTopBlocks() {
    const int end = image_.width - image_.margin, size = 1 << kTopLevel;
    for (int y = image_.margin; y < end; y += size) {
      for (int x = image_.margin; x < end; x += size) {
        if (!IsStandable(x, y, kTopLevel)) continue;
        for (int heading = 0; heading < headings_; ++heading) Push(heading, x, y, kTopLevel);
      }
    }
  }

  void Split(const PoseBlock& block) {
    const int half = 1 << (block.level - 1);
    for (const int y : {block.y + 0, block.y + half}) {
      for (const int x : {block.x + 0, block.x + half}) {
        if (IsStandable(x, y, block.level - 1)) Push(block.heading, x, y, block.level - 1);
      }
    }
  }

  // Keeps a pose unless it is the flank of a better one.
  void KeepBlock(const PoseBlock& block) {
    FoundPose pose;
    pose.position = image_.CentreOf(block.x, block.y);
    pose.yaw = YawOf(block.heading);
    pose.score = block.bound / (static_cast<double>(WallImage::kWall) * points_);
    if (result_.found.empty()) {
      least_ = std::max(least_, static_cast<int32_t>(options_.min_of_best * block.bound));
    }
    for (const FoundPose& better : result_.found) {
      const double turned = std::remainder(better.yaw - pose.yaw, 2 * std::numbers::pi);
      if ((better.position - pose.position).norm() < options_.apart_m &&
          std::abs(turned) < options_.apart_rad) {
        return;
      }
    }
    result_.found.push_back(pose);
  }

  const WallImage& image_;
  const PoseSearchOptions& options_;
  const MaxPyramid pyramid_;
  const size_t points_;
  int32_t least_;  // Grows once the best is known.
  int headings_ = 0;
  std::vector<int32_t> offsets_;  // Offsets of cells, heading after heading.
  std::priority_queue<PoseBlock> queue_;
  PoseSearchResult result_;
};

}  // namespace

MaxPyramid::MaxPyramid(const WallImage& image, int levels) : width_(image.width) {
  levels_.push_back(image.values);
  for (int level = 1; level < levels; ++level) {
    const int half = 1 << (level - 1);
    const std::vector<int8_t>& fine = levels_.back();
    std::vector<int8_t> coarse(fine.size());
    for (int y = 0; y < width_; ++y) {
      for (int x = 0; x < width_; ++x) {
        const auto at = [&](int cx, int cy) {
          const bool inside = cx < width_ && cy < width_;
          return inside ? fine[static_cast<size_t>(cy) * width_ + cx] : WallImage::kUnknown;
        };
        coarse[static_cast<size_t>(y) * width_ + x] = std::max(
            std::max(at(x, y), at(x + half, y)), std::max(at(x, y + half), at(x + half, y + half)));
      }
    }
    levels_.push_back(std::move(coarse));
  }
}

double HeadingStep(const std::vector<Eigen::Vector2f>& walls) {
  double reach = kMinHeadingReachM;
  for (const Eigen::Vector2f& wall : walls) reach = std::max<double>(reach, wall.norm());
  return MapMemory::kCellM / reach;
}

std::vector<Eigen::Vector2i> WallOffsets(const std::vector<Eigen::Vector2f>& walls, double yaw) {
  const Eigen::Rotation2Df turn(static_cast<float>(yaw));
  std::vector<Eigen::Vector2i> offsets;
  offsets.reserve(walls.size());
  for (const Eigen::Vector2f& wall : walls) {
    const Eigen::Vector2f cell = (turn * wall / static_cast<float>(MapMemory::kCellM));
    offsets.emplace_back(static_cast<int>(std::lround(cell.x())),
                         static_cast<int>(std::lround(cell.y())));
  }
  return offsets;
}

PoseSearchResult SearchPoses(const WallImage& image, const std::vector<Eigen::Vector2f>& walls,
                             const PoseSearchOptions& options) {
  if (walls.empty()) return {{}, 0, true};
  return Search(image, walls, options).Run();
}

}  // namespace isthmus::floam
