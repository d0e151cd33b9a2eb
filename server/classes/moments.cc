#include "server/classes/moments.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace isthmus::classes {
namespace {

using Index = Eigen::Vector3i;

// Has 21 bits an axis; cells farther off wrap, which mixes their sums but breaks nothing.
uint64_t KeyOf(const Index& cell) {
  const auto part = [](int i) { return static_cast<uint64_t>(i) & 0x1fffff; };
  return part(cell.x()) << 42 | part(cell.y()) << 21 | part(cell.z());
}

}  // namespace

struct Moments::Cell {
  Index index;
  Sums sums;
};

void Moments::Sums::Add(const Sums& other) {
  n += other.n;
  sum += other.sum;
  for (size_t i = 0; i < products.size(); ++i) products[i] += other.products[i];
  cells += other.cells;
}

Moments::Moments(std::span<const Eigen::Vector3f> points) {
  absl::flat_hash_map<uint64_t, uint32_t> numbers;
  std::vector<Cell> cells;
  for (const Eigen::Vector3f& point : points) {
    const Eigen::Vector3d p = point.cast<double>();
    const Index index = (p / kCellM).array().floor().cast<int>();
    const auto [it, is_new] = numbers.try_emplace(KeyOf(index), cells.size());
    if (is_new) cells.push_back({index, {}});
    Sums& sums = cells[it->second].sums;
    sums.cells = 1;
    ++sums.n;
    sums.sum += p;
    sums.products[0] += p.x() * p.x();
    sums.products[1] += p.x() * p.y();
    sums.products[2] += p.x() * p.z();
    sums.products[3] += p.y() * p.y();
    sums.products[4] += p.y() * p.z();
    sums.products[5] += p.z() * p.z();
  }
  double edge_m = kCellM;
  for (Level& level : levels_) {
    level.edge_m = edge_m;
    AddBlocks(cells, &level);
    edge_m *= 2;
    numbers.clear();
    std::vector<Cell> coarser;
    for (const Cell& cell : cells) {
      const Index index = cell.index.unaryExpr([](int i) { return i >> 1; });
      const auto [it, is_new] = numbers.try_emplace(KeyOf(index), coarser.size());
      if (is_new) coarser.push_back({index, {}});
      coarser[it->second].sums.Add(cell.sums);
    }
    cells = std::move(coarser);
  }
}

void Moments::AddBlocks(const std::vector<Cell>& cells, Level* level) {
  for (const Cell& cell : cells) {
    for (int corner = 0; corner < 8; ++corner) {
      const Index lowest = cell.index - Index(corner & 1, corner >> 1 & 1, corner >> 2);
      const auto [it, is_new] = level->numbers.try_emplace(KeyOf(lowest), level->blocks.size());
      if (is_new) level->blocks.emplace_back();
      level->blocks[it->second].Add(cell.sums);
    }
  }
}

const Shape& Moments::ShapeOf(Sums* sums) {
  Shape& shape = sums->shape;
  if (std::exchange(sums->has_shape, true)) return shape;
  shape.cells = static_cast<float>(sums->cells);
  if (sums->n < 3) return shape;
  const Eigen::Vector3d mean = sums->sum / sums->n;
  const auto& products = sums->products;
  Eigen::Matrix3d covariance;
  covariance << products[0], products[1], products[2], products[1], products[3], products[4],
      products[2], products[4], products[5];
  covariance = covariance / sums->n - mean * mean.transpose();
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(covariance);
  const Eigen::Vector3f s = solver.eigenvalues().cwiseMax(0).cwiseSqrt().cast<float>();
  if (!(s[2] > 0)) return shape;
  shape.linear = (s[2] - s[1]) / s[2];
  shape.planar = (s[1] - s[0]) / s[2];
  shape.scattered = s[0] / s[2];
  shape.thickness_m = s[0];
  shape.normal = solver.eigenvectors().col(0).cast<float>();
  shape.normal_z = std::abs(shape.normal.z());
  shape.along_z = static_cast<float>(std::abs(solver.eigenvectors()(2, 2)));
  return shape;
}

const Shape& Moments::At(int level, const Eigen::Vector3f& place) {
  static const Shape kNone;
  Level& at = levels_[static_cast<size_t>(level)];
  const Index lowest = (place.cast<double>() / at.edge_m - Eigen::Vector3d::Constant(0.5))
                           .array()
                           .floor()
                           .cast<int>();
  const auto it = at.numbers.find(KeyOf(lowest));
  return it == at.numbers.end() ? kNone : ShapeOf(&at.blocks[it->second]);
}

void Moments::ForEach(int level, const std::function<void(const Shape&, double)>& visit) {
  for (Sums& sums : levels_[static_cast<size_t>(level)].blocks) visit(ShapeOf(&sums), sums.n);
}

}  // namespace isthmus::classes
