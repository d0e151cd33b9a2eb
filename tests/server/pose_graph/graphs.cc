#include "tests/server/pose_graph/graphs.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace isthmus::pose_graph {

Matrix6d EdgeNoise::Information() const {
  Vector6d diagonal;
  diagonal << Eigen::Vector3d::Constant(1 / (position_m * position_m)),
      Eigen::Vector3d::Constant(1 / (rotation_rad * rotation_rad));
  return diagonal.asDiagonal();
}

Vector6d GraphMaker::RandomTwist(double distance, double angle) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::normal_distribution<double> normal;
  Vector6d twist;
  for (int i = 0; i < 3; ++i) twist[i] = distance * uniform(random_);
  const Eigen::Vector3d axis(normal(random_), normal(random_), normal(random_));
  twist.tail<3>() = angle * uniform(random_) * axis.normalized();
  return twist;
}

Pose GraphMaker::RandomPose(double distance, double angle) {
  const Vector6d twist = RandomTwist(distance, angle);
  Vector6d turn = twist;
  turn.head<3>().setZero();
  return Pose(Exp(turn).rotation(), twist.head<3>());
}

Edge GraphMaker::Measure(const std::vector<Pose>& truth, int a, int b, const EdgeNoise& noise,
                         bool exact) {
  const Pose T_a_b = truth[static_cast<size_t>(a)].Inverse() * truth[static_cast<size_t>(b)];
  std::normal_distribution<double> normal;
  Vector6d twist = Vector6d::Zero();
  for (int i = 0; i < 6 && !exact; ++i) {
    twist[i] = normal(random_) * (i < 3 ? noise.position_m : noise.rotation_rad);
  }
  Edge edge;
  edge.a = a;
  edge.b = b;
  edge.T_a_b = Exp(twist) * T_a_b;
  edge.information = noise.Information();
  return edge;
}

std::vector<Pose> Ring(int n, double radius) {
  std::vector<Pose> poses;
  for (int i = 0; i < n; ++i) {
    const double angle = 2 * std::numbers::pi * i / n;
    poses.push_back(Pose::FromXyzRpy(radius * std::cos(angle), radius * std::sin(angle),
                                     std::sin(2 * angle), 0.05 * std::sin(3 * angle),
                                     0.05 * std::cos(2 * angle), angle + std::numbers::pi / 2));
  }
  return poses;
}

std::vector<Pose> Grid(int rows, int columns) {
  std::vector<Pose> poses;
  for (int row = 0; row < rows; ++row) {
    for (int i = 0; i < columns; ++i) {
      const bool back = row % 2 == 1;
      const int column = back ? columns - 1 - i : i;
      poses.push_back(Pose::FromXyzRpy(10.0 * column, 10.0 * row, 0.3 * std::sin(column), 0, 0,
                                       back ? std::numbers::pi : 0));
    }
  }
  return poses;
}

void AddOdometry(const std::vector<Pose>& truth, const EdgeNoise& noise, GraphMaker* maker,
                 Problem* problem, bool exact) {
  problem->poses = {truth.front()};
  for (int i = 1; i < static_cast<int>(truth.size()); ++i) {
    const Edge edge = maker->Measure(truth, i - 1, i, noise, exact);
    problem->poses.push_back(problem->poses.back() * edge.T_a_b);
    problem->edges.push_back(edge);
  }
}

void AddRowLinks(const std::vector<Pose>& truth, int rows, int columns, const EdgeNoise& noise,
                 GraphMaker* maker, Problem* problem) {
  for (int row = 1; row < rows; ++row) {
    for (int i = 0; i < columns; ++i) {
      // The way back passes beside the node that came as long before the turn.
      const int b = row * columns + i, a = row * columns - 1 - i;
      if (a + 1 != b) problem->edges.push_back(maker->Measure(truth, a, b, noise));
    }
  }
}

double LargestDistance(const std::vector<Pose>& a, const std::vector<Pose>& b) {
  double largest = a.size() == b.size() ? 0 : 1e300;
  for (size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    largest = std::max(largest, (a[i].translation() - b[i].translation()).norm());
  }
  return largest;
}

double Rmse(const std::vector<Pose>& poses, const std::vector<Pose>& truth) {
  const Pose T_truth_poses = truth.front() * poses.front().Inverse();
  double sum = 0;
  for (size_t i = 0; i < truth.size(); ++i) {
    sum += (T_truth_poses * poses[i].translation() - truth[i].translation()).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(truth.size()));
}

}  // namespace isthmus::pose_graph
