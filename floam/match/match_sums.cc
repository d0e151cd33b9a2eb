#include "floam/match/match_sums.h"

#include <array>
#include <cstddef>

namespace isthmus::floam {
namespace {

// Rows that are summed side by side, for the sake of vector units: 40 % less time than summing
// one outer product after the other.
constexpr size_t kLanes = 8;   // Layout.
constexpr size_t kPairs = 21;  // Math: of the columns of a pose's Jacobian.

using Lanes = Eigen::Array<double, kLanes, 1>;

struct Block {
  void Set(size_t lane, const MatchRow& row) {
    const auto k = static_cast<Eigen::Index>(lane);
    for (int column = 0; column < 6; ++column) a[column][k] = row.jacobian[column];
    for (int axis = 0; axis < 3; ++axis) {
      q[axis][k] = row.q[axis];
      offset[axis][k] = row.offset[axis];
    }
    weight[k] = row.weight;
    residual[k] = row.residual;
    tau[k] = row.tau;
    tilt[k] = row.weight * row.tilt_variance;
  }

  std::array<Lanes, 6> a;
  std::array<Lanes, 3> q, offset;
  Lanes weight, residual, tau, tilt;
};

class Sums {
 public:
  void Add(const Block& block, bool with_twist) {
    const Lanes& w = block.weight;
    const Lanes wt = w * block.tau, wtt = wt * block.tau;
    const Lanes wr = w * block.residual, wrt = wt * block.residual;
    size_t pair = 0;
    for (int row = 0; row < 6; ++row) {
      const Lanes& a = block.a[row];
      pose_gradient_[row] += (wr * a).sum();
      if (with_twist) twist_gradient_[row] += (wrt * a).sum();
      for (int column = 0; column <= row; ++column, ++pair) {
        const Lanes square = a * block.a[column];
        pose_[pair] += (w * square).sum();
        along_[pair] += (block.tilt * square).sum();
        if (!with_twist) continue;
        mixed_[pair] += (wt * square).sum();
        twist_[pair] += (wtt * square).sum();
      }
    }
    AddNoise(block);
  }

  MatchSums Result() const {
    MatchSums sums;
    const Matrix6d mixed = Unpack(mixed_);
    sums.information << Unpack(pose_), mixed, mixed, Unpack(twist_);
    sums.gradient << pose_gradient_, twist_gradient_;
    const Eigen::Matrix3d cross = Skew(first_);
    Matrix6d all;
    all << tilt_ * Eigen::Matrix3d::Identity(), -cross, cross,
        second_.trace() * Eigen::Matrix3d::Identity() - second_;
    sums.noise = all - Unpack(along_);
    sums.noise_gradient = noise_gradient_;
    return sums;
  }

 private:
  using Packed = std::array<double, kPairs>;  // Lower triangle, row by row.

  static Matrix6d Unpack(const Packed& packed) {
    Matrix6d matrix;
    size_t pair = 0;
    for (int row = 0; row < 6; ++row) {
      for (int column = 0; column <= row; ++column, ++pair)
        matrix(row, column) = matrix(column, row) = packed[pair];
    }
    return matrix;
  }

  // With B^T e for the e that the tilt of the normal is: its variance times `offset` less what is
  // along the normal, which is the residual.
  void AddNoise(const Block& block) {
    const Lanes& s = block.tilt;
    const std::array<Lanes, 3>&q = block.q, &off = block.offset;
    tilt_ += s.sum();
    for (int row = 0; row < 3; ++row) {
      const int next = (row + 1) % 3, last = (row + 2) % 3;
      const Lanes sq = s * q[row];
      first_[row] += sq.sum();
      for (int column = 0; column < 3; ++column) second_(row, column) += (sq * q[column]).sum();
      noise_gradient_[row] += (s * off[row]).sum();
      noise_gradient_[3 + row] += (s * (q[next] * off[last] - q[last] * off[next])).sum();
    }
    const Lanes along = s * (block.a[0] * off[0] + block.a[1] * off[1] + block.a[2] * off[2]);
    for (int row = 0; row < 6; ++row) noise_gradient_[row] -= (along * block.a[row]).sum();
  }

  Packed pose_{}, mixed_{}, twist_{}, along_{};
  Vector6d pose_gradient_ = Vector6d::Zero(), twist_gradient_ = Vector6d::Zero();
  double tilt_ = 0;
  Eigen::Vector3d first_ = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second_ = Eigen::Matrix3d::Zero();
  Vector6d noise_gradient_ = Vector6d::Zero();
};

}  // namespace

MatchSums SumOf(const std::vector<MatchRow>& rows, bool with_twist) {
  const MatchRow nothing{Vector6d::Zero()};
  Sums sums;
  Block block;
  for (size_t begin = 0; begin < rows.size(); begin += kLanes) {
    for (size_t k = 0; k < kLanes; ++k)
      block.Set(k, begin + k < rows.size() ? rows[begin + k] : nothing);
    sums.Add(block, with_twist);
  }
  return sums.Result();
}

}  // namespace isthmus::floam
