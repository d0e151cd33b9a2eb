#include "server/classes/columns.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "server/classes/limits.h"

namespace isthmus::classes {
namespace {

constexpr uint64_t BitsBetween(int from, int to) {
  return (~uint64_t{0} << from) & ~(~uint64_t{0} << to);
}
constexpr uint64_t kObstacle = BitsBetween(kFirstObstacleBin, kEndObstacleBin);  // Layout

int TopBin(uint64_t bins) { return static_cast<int>(std::bit_width(bins)); }
float HeightOf(int bin) { return kLowestBinM + kBinM * static_cast<float>(bin); }

// Sums over columns, in columns.
struct PlanSums {
  double n = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0;

  void Add(double at_x, double at_y) {
    ++n;
    x += at_x;
    y += at_y;
    xx += at_x * at_x;
    xy += at_x * at_y;
    yy += at_y * at_y;
  }
  // Standard deviations along the principal directions, the larger first.
  std::array<double, 2> Deviations() const {
    const double a = xx / n - x * x / n / n, b = xy / n - x * y / n / n, c = yy / n - y * y / n / n;
    const double middle = (a + c) / 2, half = std::hypot((a - c) / 2, b);
    return {std::sqrt(std::max(middle + half, 0.0)), std::sqrt(std::max(middle - half, 0.0))};
  }
};

}  // namespace

Columns::Columns(std::span<const Eigen::Vector3f> points, const GroundGrid& ground)
    : ground_(ground), layout_(ground.layout().Halved()), columns_(layout_.size()) {
  for (const Eigen::Vector3f& p : points) {
    const Eigen::Vector2i at = layout_.Find(p);
    columns_[layout_.At(at.x(), at.y())].bins |= uint64_t{1} << BinOf(p);
  }
  FindCourses();
  LookBeside();
}

int Columns::BinOf(const Eigen::Vector3f& p) const {
  const float bin = (p.z() - ground_.At(p).ground_m - kLowestBinM) / kBinM;
  return static_cast<int>(std::clamp(bin, 0.0F, static_cast<float>(kBins - 1)));
}

void Columns::FindCourses() {
  for (int y = 0; y < layout_.height; ++y) {
    for (int x = 0; x < layout_.width; ++x) {
      const Column& column = columns_[layout_.At(x, y)];
      if (column.course < 0 && (column.bins & kObstacle) != 0) Follow({x, y});
    }
  }
}

void Columns::Follow(const Eigen::Vector2i& from) {
  const auto number = static_cast<int32_t>(courses_.size());
  std::vector<Eigen::Vector2i> next = {from};
  columns_[layout_.At(from.x(), from.y())].course = number;
  PlanSums sums;
  int top = 0;
  while (!next.empty()) {
    const Eigen::Vector2i at = next.back();
    next.pop_back();
    sums.Add(at.x(), at.y());
    top = std::max(top, TopBin(columns_[layout_.At(at.x(), at.y())].bins));
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        if (!layout_.Has(at.x() + dx, at.y() + dy)) continue;
        Column& beside = columns_[layout_.At(at.x() + dx, at.y() + dy)];
        if (beside.course >= 0 || (beside.bins & kObstacle) == 0) continue;
        beside.course = number;
        next.emplace_back(at.x() + dx, at.y() + dy);
      }
    }
  }
  const auto [length, width] = sums.Deviations();
  courses_.push_back({static_cast<float>(sums.n), static_cast<float>(4 * length * layout_.edge_m),
                      static_cast<float>(4 * width * layout_.edge_m), HeightOf(top)});
}

void Columns::LookBeside() {
  constexpr double kAround = (2.0 * kCourseColumns + 1) * (2 * kCourseColumns + 1);
  for (int y = 0; y < layout_.height; ++y) {
    for (int x = 0; x < layout_.width; ++x) {
      Column& column = columns_[layout_.At(x, y)];
      if (column.bins == 0) continue;
      PlanSums sums;
      for (int dy = -kCourseColumns; dy <= kCourseColumns; ++dy) {
        for (int dx = -kCourseColumns; dx <= kCourseColumns; ++dx) {
          if (!layout_.Has(x + dx, y + dy)) continue;
          if ((columns_[layout_.At(x + dx, y + dy)].bins & kObstacle) != 0) sums.Add(dx, dy);
        }
      }
      column.beside = static_cast<float>(sums.n / kAround);
      if (sums.n < 2) continue;
      const auto [length, width] = sums.Deviations();
      column.along = static_cast<float>((length - width) / length);
    }
  }
}

const Column& Columns::At(const Eigen::Vector3f& p) const {
  const Eigen::Vector2i at = layout_.Find(p);
  return columns_[layout_.At(at.x(), at.y())];
}

const Course* Columns::CourseAt(const Eigen::Vector3f& p) const {
  const int32_t course = At(p).course;
  return course < 0 ? nullptr : &courses_[static_cast<size_t>(course)];
}

Stretch Columns::StretchAt(const Eigen::Vector3f& p) const {
  const uint64_t bins = At(p).bins;
  const int bin = BinOf(p);
  const int above = std::countr_one(bins >> bin);
  const int below = std::countl_one(bins << (kBins - 1 - bin)) - 1;
  const int top = bin + above;
  return {HeightOf(bin - below), HeightOf(top), static_cast<float>(std::popcount(bins)),
          static_cast<float>(top < kBins ? std::popcount(bins >> top) : 0), HeightOf(TopBin(bins))};
}

float Columns::BesideAtHeight(const Eigen::Vector3f& p) const {
  const Eigen::Vector2i at = layout_.Find(p);
  const int bin = BinOf(p);
  int count = 0;
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      if (!layout_.Has(at.x() + dx, at.y() + dy)) continue;
      count += static_cast<int>(columns_[layout_.At(at.x() + dx, at.y() + dy)].bins >> bin & 1);
    }
  }
  return static_cast<float>(count);
}

}  // namespace isthmus::classes
