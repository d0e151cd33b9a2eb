#include "client/evaluation/picture.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <filesystem>
#include <utility>

#include "client/evaluation/limits.h"
#include "core/io/file_io.h"
#include "core/io/output_file.h"

namespace isthmus::evaluation {
namespace {

// Told apart by everybody: Okabe and Ito, "Color Universal Design", 2008; the yellow left out,
// which is illegible on white.
constexpr Color kOnWhite[] = {{0, 114, 178},  {213, 94, 0}, {0, 158, 115},
                              {160, 70, 150}, {120, 90, 0}, {86, 160, 213}};
constexpr Color kOnBlack[] = {{86, 180, 233},  {255, 150, 50}, {60, 220, 160},
                              {230, 150, 220}, {240, 228, 66}, {150, 200, 255}};

Color Mix(Color a, Color b, double share_of_b) {
  for (int i = 0; i < 3; ++i) {
    a[i] = static_cast<uint8_t>(std::lround(a[i] + share_of_b * (b[i] - a[i])));
  }
  return a;
}

// 1, 2 or 5 times a power of ten, at most `length`.
double RoundLength(double length) {
  const double power = std::pow(10, std::floor(std::log10(length)));
  for (const double factor : {5.0, 2.0}) {
    if (factor * power <= length) return factor * power;
  }
  return power;
}

}  // namespace

absl::StatusOr<TopDownPicture> TopDownPicture::Create(const Box& extent,
                                                      const std::vector<std::string>& robots,
                                                      const PictureOptions& options) {
  const Eigen::Vector2d size = (extent.max - extent.min).head<2>();
  if (!size.allFinite() || size.minCoeff() <= 0) {
    return absl::InvalidArgumentError(
        "the picture's extent has no area; is there anything in the map?");
  }
  if (options.max_side_px < 200 || options.max_side_px > 10000) {
    return absl::InvalidArgumentError(absl::StrCat(
        "a picture's longer side must be 200 to 10000 pixels, not ", options.max_side_px));
  }
  if (!(options.point_m > 0)) {
    return absl::InvalidArgumentError("the size of points must be positive");
  }
  return TopDownPicture(extent, robots, options);
}

TopDownPicture::TopDownPicture(const Box& extent, const std::vector<std::string>& robots,
                               const PictureOptions& options)
    : extent_(extent), robots_(robots), options_(options) {
  const Eigen::Vector2d size = (extent.max - extent.min).head<2>();
  meters_per_pixel_ = size.maxCoeff() / options.max_side_px;
  const auto pixels = [&](double m) {
    // A strip of a map still gets a picture of some height.
    return std::max(100, static_cast<int>(std::ceil(m / meters_per_pixel_ - 1e-9)));
  };
  width_ = pixels(size.x());
  height_ = pixels(size.y());
  heights_.resize(robots.size());
}

Color TopDownPicture::RobotColor(uint32_t robot) const {
  return options_.dark ? kOnBlack[robot % std::size(kOnBlack)]
                       : kOnWhite[robot % std::size(kOnWhite)];
}

void TopDownPicture::Add(const std::vector<MapPoint>& points) {
  const int splat =
      std::max(1, static_cast<int>(std::lround(options_.point_m / meters_per_pixel_)));
  for (const MapPoint& p : points) {
    const bool in_cut = p.z >= options_.min_z_m && p.z <= options_.max_z_m;
    if (p.robot >= heights_.size() || !in_cut || std::abs(p.z) > kHighest) continue;
    const double px = PixelX(p.x), py = PixelY(p.y);
    if (!(px >= 0 && py >= 0 && px < width_ && py < height_)) continue;
    auto& heights = heights_[p.robot];
    if (heights.empty()) heights.resize(static_cast<size_t>(width_) * height_);
    const auto step = static_cast<int64_t>(std::floor(p.z / kHeightStep));
    const uint32_t bit = 1u << (step & 31);
    const int left = static_cast<int>(px) - (splat - 1) / 2;
    const int top = static_cast<int>(py) - (splat - 1) / 2;
    for (int y = std::max(0, top); y < std::min(height_, top + splat); ++y) {
      for (int x = std::max(0, left); x < std::min(width_, left + splat); ++x) {
        heights[static_cast<size_t>(y) * width_ + x] |= bit;
      }
    }
  }
}

void TopDownPicture::AddTrajectory(uint32_t robot, Trajectory trajectory) {
  std::erase_if(trajectory, [](const StampedPose& entry) { return !entry.pose.IsFinite(); });
  trajectories_.emplace_back(robot, std::move(trajectory));
}

void TopDownPicture::AddOutline(std::vector<Eigen::Vector2d> corners, Color color) {
  outlines_.emplace_back(std::move(corners), color);
}

void TopDownPicture::DrawGrid(Canvas& canvas) const {
  const Color paper = canvas.At(0, 0), ink = options_.dark ? Color{255, 255, 255} : Color{0, 0, 0};
  const Color line = Mix(paper, ink, 0.12), word = Mix(paper, ink, 0.45);
  const double step_m = RoundLength(kGridShare * std::max(width_, height_) * meters_per_pixel_);
  const auto name = [](double m) { return absl::StrFormat("%g", m == 0 ? 0.0 : m); };
  for (double m = std::ceil(extent_.min.x() / step_m) * step_m; PixelX(m) < width_; m += step_m) {
    canvas.Line(PixelX(m), 0, PixelX(m), height_, 1, line);
    canvas.Text(static_cast<int>(PixelX(m)) + 3, 3, name(m), 1, word);
  }
  for (double m = std::floor(extent_.max.y() / step_m) * step_m; PixelY(m) < height_; m -= step_m) {
    canvas.Line(0, PixelY(m), width_, PixelY(m), 1, line);
    canvas.Text(3, static_cast<int>(PixelY(m)) + 3, name(m), 1, word);
  }
}

void TopDownPicture::DrawOrigin(Canvas& canvas) const {
  const double x = PixelX(0), y = PixelY(0);
  if (!(x >= 0 && y >= 0 && x < width_ && y < height_)) return;
  constexpr double kArm = 14;  // Pixels.
  canvas.Line(x, y, x + 2 * kArm, y, 3, {220, 40, 40});
  canvas.Line(x, y, x, y - 2 * kArm, 3, {40, 170, 60});
  canvas.Text(static_cast<int>(x + 2 * kArm) + 4, static_cast<int>(y) - 6, "x", 2, {220, 40, 40});
  canvas.Text(static_cast<int>(x) - 5, static_cast<int>(y - 2 * kArm) - 18, "y", 2, {40, 170, 60});
}

std::string TopDownPicture::WorldFile() const {
  return absl::StrFormat("%.12g\n0\n0\n%.12g\n%.12g\n%.12g\n", meters_per_pixel_,
                         -meters_per_pixel_, extent_.min.x() + 0.5 * meters_per_pixel_,
                         extent_.max.y() - 0.5 * meters_per_pixel_);
}

void TopDownPicture::DrawPoints(Canvas& canvas) const {
  for (size_t pixel = 0; pixel < static_cast<size_t>(width_) * height_; ++pixel) {
    uint32_t all = 0;
    int total = 0;
    double color[3] = {};
    for (uint32_t robot = 0; robot < heights_.size(); ++robot) {
      if (heights_[robot].empty() || heights_[robot][pixel] == 0) continue;
      const int count = std::popcount(heights_[robot][pixel]);
      all |= heights_[robot][pixel];
      total += count;
      const Color own = RobotColor(robot);
      for (int i = 0; i < 3; ++i) color[i] += count * own[i];
    }
    if (total == 0) continue;
    Color mixed;
    for (int i = 0; i < 3; ++i) mixed[i] = static_cast<uint8_t>(color[i] / total);
    // One height (a floor) is faint, two (floor and ceiling) hardly more.
    const double share = std::min(1.0, (std::popcount(all) - 1) / (kFullHeights - 1.0));
    canvas.Blend(static_cast<int>(pixel % width_), static_cast<int>(pixel / width_), mixed,
                 0.13 + 0.87 * share);
  }
}

void TopDownPicture::DrawTrajectories(Canvas& canvas) const {
  const Color paper = canvas.At(0, 0), ink = options_.dark ? Color{255, 255, 255} : Color{0, 0, 0};
  for (const auto& [robot, poses] : trajectories_) {
    const Trajectory& trajectory = poses;  // Lambdas of clang 14 take no structured bindings.
    if (trajectory.empty()) continue;
    const auto x = [&](size_t i) { return PixelX(trajectory[i].pose.translation().x()); };
    const auto y = [&](size_t i) { return PixelY(trajectory[i].pose.translation().y()); };
    const Color line = Mix(RobotColor(robot), ink, 0.35);
    // A rim of paper around the line keeps it legible on its own robot's points.
    for (const bool rim : {true, false}) {
      size_t last = 0;
      for (size_t i = 1; i < trajectory.size(); ++i) {
        if (std::hypot(x(i) - x(last), y(i) - y(last)) < 1.5 && i + 1 < trajectory.size()) continue;
        canvas.Line(x(last), y(last), x(i), y(i), rim ? 6 : 3, rim ? paper : line);
        last = i;
      }
    }
    canvas.Disc(x(0), y(0), 8, line);
    canvas.Disc(x(0), y(0), 4.5, paper);
    canvas.Disc(x(trajectory.size() - 1), y(trajectory.size() - 1), 7, line);
  }
}

void TopDownPicture::DrawOutlines(Canvas& canvas) const {
  for (const auto& [corners, color] : outlines_) {
    for (size_t i = 0; i < corners.size(); ++i) {
      const Eigen::Vector2d &from = corners[i], &to = corners[(i + 1) % corners.size()];
      canvas.Line(PixelX(from.x()), PixelY(from.y()), PixelX(to.x()), PixelY(to.y()), 3, color);
    }
  }
}

int TopDownPicture::DrawLegend(int top, Canvas* canvas) const {
  const Color ink = options_.dark ? Color{230, 230, 230} : Color{40, 40, 40};
  constexpr int kScale = 2, kRow = 24, kMargin = 12, kGap = 28, kBox = 14;
  int x = kMargin, y = top + kMargin;
  const double length_m = RoundLength(0.22 * width_ * meters_per_pixel_);
  const int bar = static_cast<int>(std::lround(length_m / meters_per_pixel_));
  const std::string length = absl::StrFormat("%g m", length_m);
  if (canvas != nullptr) {
    canvas->Rectangle(x, y + 6, x + bar, y + 8, ink);
    canvas->Rectangle(x, y, x + 1, y + kBox, ink);
    canvas->Rectangle(x + bar - 1, y, x + bar, y + kBox, ink);
    canvas->Text(x + bar + 10, y, length, kScale, ink);
  }
  x += bar + 10 + Canvas::TextWidth(length, kScale) + kGap;
  for (uint32_t i = 0; i < robots_.size(); ++i) {
    const int advance = kBox + 10 + Canvas::TextWidth(robots_[i], kScale);
    if (x + advance > width_ - kMargin) {
      x = kMargin;
      y += kRow;
    }
    if (canvas != nullptr) {
      canvas->Rectangle(x, y, x + kBox, y + kBox, RobotColor(i));
      canvas->Text(x + kBox + 10, y, robots_[i], kScale, ink);
    }
    x += advance + kGap;
  }
  if (options_.caption.empty()) return y + kRow;
  y += kRow;
  if (canvas != nullptr) canvas->Text(kMargin, y, options_.caption, kScale, ink);
  return y + kRow;
}

Canvas TopDownPicture::Draw() const {
  const int height = options_.legend ? DrawLegend(height_, nullptr) : height_;
  Canvas canvas(width_, height, options_.dark ? Color{12, 14, 18} : Color{255, 255, 255});
  if (options_.grid) DrawGrid(canvas);
  DrawPoints(canvas);
  DrawTrajectories(canvas);
  DrawOutlines(canvas);
  if (options_.grid) DrawOrigin(canvas);
  if (options_.legend) DrawLegend(height_, &canvas);
  return canvas;
}

absl::Status TopDownPicture::WritePng(const std::string& path) const {
  const auto bytes = Draw().EncodePng();
  if (!bytes.ok()) return bytes.status();
  return io::WriteOutput(path, *bytes);
}

Box PictureExtent(const std::vector<MapPoint>& points, const std::vector<Trajectory>& trajectories,
                  double outliers) {
  Box box;
  for (const Trajectory& trajectory : trajectories) {
    for (const StampedPose& entry : trajectory) box.Extend(entry.pose.translation());
  }
  std::vector<Eigen::Vector3f> finite;
  for (const MapPoint& p : points) {
    const Eigen::Vector3f at(p.x, p.y, p.z);
    if (at.allFinite()) finite.push_back(at);
  }
  if (!finite.empty()) {
    Eigen::Vector3d low, high;
    const auto cut = static_cast<ptrdiff_t>(outliers * static_cast<double>(finite.size() - 1));
    for (int axis = 0; axis < 3; ++axis) {
      const auto less = [axis](const auto& a, const auto& b) { return a[axis] < b[axis]; };
      std::nth_element(finite.begin(), finite.begin() + cut, finite.end(), less);
      low[axis] = finite[cut][axis];
      std::nth_element(finite.begin(), finite.end() - 1 - cut, finite.end(), less);
      high[axis] = (*(finite.end() - 1 - cut))[axis];
    }
    box.Extend(low);
    box.Extend(high);
  }
  if (box.empty()) return box;
  const Eigen::Vector3d margin = 0.02 * (box.max - box.min);
  box.Extend(Eigen::Vector3d(box.min - margin));
  box.Extend(Eigen::Vector3d(box.max + margin));
  return box;
}

std::string WorldFilePath(const std::string& picture) {
  std::filesystem::path path(picture);
  return path.replace_extension(".pgw").string();
}

absl::Status WritePicture(const std::string& path, const std::vector<MapPoint>& points,
                          const std::vector<Trajectory>& trajectories,
                          const std::vector<std::string>& robots, const PictureOptions& options,
                          bool world_file) {
  auto picture = TopDownPicture::Create(PictureExtent(points, trajectories), robots, options);
  if (!picture.ok()) return picture.status();
  picture->Add(points);
  for (size_t i = 0; i < trajectories.size(); ++i) {
    picture->AddTrajectory(static_cast<uint32_t>(i), trajectories[i]);
  }
  absl::Status written = picture->WritePng(path);
  if (!written.ok() || !world_file) return written;
  return io::WriteFile(WorldFilePath(path), picture->WorldFile());
}

}  // namespace isthmus::evaluation
