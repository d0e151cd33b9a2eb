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

Index IndexOf(const Eigen::Vector3d& place, double edge_m) {
  return (place / edge_m).array().floor().cast<int>();
}

}  // namespace

void Moments::Sums::Add(const Sums& other) {
  n += other.n;
  sum += other.sum;
  for (size_t i = 0; i < products.size(); ++i) products[i] += other.products[i];
  cells += other.cells;
}

void Moments::Put(const Index& index, const Sums& sums, Level* level) {
  const auto [it, is_new] = level->numbers.try_emplace(KeyOf(index), level->cells.size());
  if (is_new) level->cells.push_back({index, {}});
  level->cells[it->second].sums.Add(sums);
}

Moments::Moments(std::span<const Eigen::Vector3f> points) {
  levels_[0].edge_m = kCellM;
  for (const Eigen::Vector3f& point : points) {
    const Eigen::Vector3d p = point.cast<double>();
    const Index index = IndexOf(p, kCellM);
    const Sums sums{
        1,
        p,
        {p.x() * p.x(), p.x() * p.y(), p.x() * p.z(), p.y() * p.y(), p.y() * p.z(), p.z() * p.z()}};
    Put(index, sums, &levels_[0]);
  }
  for (Cell& cell : levels_[0].cells) cell.sums.cells = 1;
  for (size_t i = 1; i < levels_.size(); ++i) {
    levels_[i].edge_m = 2 * levels_[i - 1].edge_m;
    for (const Cell& cell : levels_[i - 1].cells) {
      Put(cell.index.unaryExpr([](int k) { return k >> 1; }), cell.sums, &levels_[i]);
    }
  }
}

Shape Moments::ShapeOf(const Sums& sums) {
  Shape shape;
  shape.cells = static_cast<float>(sums.cells);
  if (sums.n < 3) return shape;
  const Eigen::Vector3d mean = sums.sum / sums.n;
  const auto& products = sums.products;
  Eigen::Matrix3d covariance;
  covariance << products[0], products[1], products[2], products[1], products[3], products[4],
      products[2], products[4], products[5];
  covariance = covariance / sums.n - mean * mean.transpose();
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

Shape Moments::At(int level, const Eigen::Vector3f& place) {
  Level& at = levels_[static_cast<size_t>(level)];
  const double edge_m = at.edge_m;
  const Index lowest =
      IndexOf(place.cast<double>() - Eigen::Vector3d::Constant(edge_m / 2), edge_m);
  const auto [it, is_new] = at.shapes.try_emplace(KeyOf(lowest));
  if (!is_new) return it->second;
  Sums block;
  for (int corner = 0; corner < 8; ++corner) {
    const auto cell =
        at.numbers.find(KeyOf(lowest + Index(corner & 1, corner >> 1 & 1, corner >> 2)));
    if (cell != at.numbers.end()) block.Add(at.cells[cell->second].sums);
  }
  return it->second = ShapeOf(block);
}

void Moments::ForEach(int level, const std::function<void(const Shape&, double)>& visit) const {
  for (const Cell& cell : levels_[static_cast<size_t>(level)].cells) {
    visit(ShapeOf(cell.sums), cell.sums.n);
  }
}

}  // namespace isthmus::classes
