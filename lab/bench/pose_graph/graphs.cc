#include "lab/bench/pose_graph/graphs.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <utility>

namespace isthmus::bench {
namespace {

using pose_graph::Edge;

struct Noise {
  double position_m;
  double rotation_rad;
};

class Surveyor {
 public:
  Surveyor(uint64_t seed, const std::vector<Pose>& truth) : random_(seed), truth_(truth) {}

  // A measurement of T_a_b with this noise, and its information.
  Edge Measure(int a, int b, const Noise& noise) {
    Vector6d sigma;
    sigma << Eigen::Vector3d::Constant(noise.position_m),
        Eigen::Vector3d::Constant(noise.rotation_rad);
    Edge edge;
    edge.a = a;
    edge.b = b;
    edge.T_a_b = Exp(Draw(sigma)) * Relative(a, b);
    edge.information = sigma.cwiseAbs2().cwiseInverse().asDiagonal();
    return edge;
  }

  void AddOdometry(const Noise& noise, pose_graph::Problem* problem) {
    problem->poses = {truth_.front()};
    for (int i = 1; i < static_cast<int>(truth_.size()); ++i) {
      problem->edges.push_back(Measure(i - 1, i, noise));
      problem->poses.push_back(problem->poses.back() * problem->edges.back().T_a_b);
    }
  }

  void AddClosure(int a, int b, const Noise& noise, pose_graph::Problem* problem) {
    problem->edges.push_back(Measure(a, b, noise));
    problem->edges.back().may_be_wrong = true;
  }

  std::mt19937_64& random() { return random_; }

 private:
  Pose Relative(int a, int b) const {
    return truth_[static_cast<size_t>(a)].Inverse() * truth_[static_cast<size_t>(b)];
  }

  Vector6d Draw(const Vector6d& sigma) {
    std::normal_distribution<double> normal;
    Vector6d twist;
    for (int i = 0; i < 6; ++i) twist[i] = sigma[i] * normal(random_);
    return twist;
  }

  std::mt19937_64 random_;
  const std::vector<Pose>& truth_;
};

// Poses at the points, each looking at the next.
std::vector<Pose> LookAhead(const std::vector<Eigen::Vector3d>& points) {
  std::vector<Pose> poses;
  for (size_t i = 0; i < points.size(); ++i) {
    const size_t j = std::min(i, points.size() - 2);
    const Eigen::Vector3d ahead = points[j + 1] - points[j];
    poses.push_back(Pose::FromXyzRpy(points[i].x(), points[i].y(), points[i].z(), 0,
                                     -std::atan2(ahead.z(), ahead.head<2>().norm()),
                                     std::atan2(ahead.y(), ahead.x())));
  }
  return poses;
}

// All pairs closer than `distance` that are at least `apart` nodes apart.
std::vector<std::pair<int, int>> Neighbours(const std::vector<Pose>& truth, double distance,
                                            int apart) {
  std::vector<std::pair<int, int>> pairs;
  for (int a = 0; a < static_cast<int>(truth.size()); ++a) {
    for (int b = a + apart; b < static_cast<int>(truth.size()); ++b) {
      const Eigen::Vector3d gap =
          truth[static_cast<size_t>(a)].translation() - truth[static_cast<size_t>(b)].translation();
      if (gap.norm() < distance) pairs.emplace_back(a, b);
    }
  }
  return pairs;
}

// Metre by metre round a rectangle, from its corner at the origin.
Eigen::Vector2d AlongRectangle(double s, double width, double depth) {
  if (s < width) return {s, 0};
  if (s < width + depth) return {width, s - width};
  if (s < 2 * width + depth) return {2 * width + depth - s, depth};
  return {0, std::max(0.0, 2 * (width + depth) - s)};
}

std::vector<Eigen::Vector2d> WalkStreets(int crossings, double block, double step, size_t nodes,
                                         std::mt19937_64* random) {
  constexpr int kDirections[4][2] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};
  int x = 0, y = 0, direction = 0;
  std::vector<Eigen::Vector2d> points;
  double along = 0;
  while (points.size() < nodes) {
    for (; along < block && points.size() < nodes; along += step) {
      points.emplace_back(block * x + along * kDirections[direction][0],
                          block * y + along * kDirections[direction][1]);
    }
    along -= block;
    x += kDirections[direction][0];
    y += kDirections[direction][1];
    const int back = (direction + 2) % 4;
    const auto leaves = [&](int d) {
      const int nx = x + kDirections[d][0], ny = y + kDirections[d][1];
      return nx < 0 || ny < 0 || nx >= crossings || ny >= crossings;
    };
    do {
      direction = static_cast<int>((*random)() % 4);
    } while (direction == back || leaves(direction));
  }
  return points;
}

}  // namespace

BenchmarkGraph SphereGraph(uint64_t seed) {
  constexpr int kRounds = 50, kPerRound = 50;
  constexpr double kRadius = 50;
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < kRounds * kPerRound; ++i) {
    const double latitude = std::numbers::pi * ((i + 0.5) / (kRounds * kPerRound) - 0.5);
    const double longitude = 2 * std::numbers::pi * i / kPerRound;
    points.push_back(kRadius * Eigen::Vector3d(std::cos(latitude) * std::cos(longitude),
                                               std::cos(latitude) * std::sin(longitude),
                                               std::sin(latitude)));
  }
  BenchmarkGraph graph{"sphere", {}, LookAhead(points)};
  Surveyor surveyor(seed, graph.truth);
  const Noise noise{0.1, 0.05};
  surveyor.AddOdometry(noise, &graph.problem);
  for (int b = kPerRound; b < kRounds * kPerRound; ++b) {
    surveyor.AddClosure(b - kPerRound, b, noise, &graph.problem);
  }
  return graph;
}

BenchmarkGraph GarageGraph(uint64_t seed) {
  constexpr int kFloors = 5, kLanes = 3;
  constexpr double kHeight = 3, kStep = 2, kLane = 4;
  std::vector<Eigen::Vector3d> points;
  for (int floor = 0; floor < kFloors; ++floor) {
    for (int lane = 0; lane < kLanes; ++lane) {
      const double width = 70 - 2 * kLane * lane, depth = 40 - 2 * kLane * lane;
      const double around = 2 * (width + depth);
      for (double s = 0; s < around; s += kStep) {
        const Eigen::Vector2d p = AlongRectangle(s, width, depth);
        // The last 40 m of the last lane are the ramp to the next floor.
        const bool ramp = lane == kLanes - 1 && floor + 1 < kFloors && s > around - 40;
        const double z = kHeight * (floor + (ramp ? (s - around + 40) / 40 : 0));
        points.emplace_back(p.x() + kLane * lane, p.y() + kLane * lane, z);
      }
    }
  }
  BenchmarkGraph graph{"garage", {}, LookAhead(points)};
  Surveyor surveyor(seed, graph.truth);
  surveyor.AddOdometry({0.03, 0.004}, &graph.problem);
  for (const auto& [a, b] : Neighbours(graph.truth, 5.2, 20)) {
    // A lane's level part is not seen from the ramp above it.
    const double rise = graph.truth[static_cast<size_t>(a)].translation().z() -
                        graph.truth[static_cast<size_t>(b)].translation().z();
    if (std::abs(rise) < 1) surveyor.AddClosure(a, b, {0.03, 0.003}, &graph.problem);
  }
  return graph;
}

BenchmarkGraph CampusGraph(uint64_t seed) {
  constexpr size_t kNodes = 2000, kEdges = 6000;
  std::mt19937_64 random(seed);
  std::vector<Eigen::Vector3d> points;
  for (const Eigen::Vector2d& p : WalkStreets(7, 60, 8, kNodes, &random)) {
    points.emplace_back(p.x(), p.y(), 2 * std::sin(p.x() / 80) + std::cos(p.y() / 60));
  }
  BenchmarkGraph graph{"campus", {}, LookAhead(points)};
  Surveyor surveyor(seed + 1, graph.truth);
  surveyor.AddOdometry({0.05, 0.004}, &graph.problem);
  auto pairs = Neighbours(graph.truth, 10, 10);
  std::shuffle(pairs.begin(), pairs.end(), random);
  pairs.resize(std::min(pairs.size(), kEdges - graph.problem.edges.size()));
  for (const auto& [a, b] : pairs) surveyor.AddClosure(a, b, {0.03, 0.003}, &graph.problem);
  return graph;
}

void AddFalseClosures(double share, uint64_t seed, BenchmarkGraph* graph) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> metres(-5, 5), radians(-0.2, 0.2), turn(-3.1, 3.1);
  std::uniform_int_distribution<int> node(0, static_cast<int>(graph->problem.poses.size()) - 1);
  const auto closures = std::count_if(graph->problem.edges.begin(), graph->problem.edges.end(),
                                      [](const Edge& edge) { return edge.may_be_wrong; });
  int wanted = static_cast<int>(static_cast<double>(closures) * share / (1 - share));
  while (wanted > 0) {
    const int a = node(random), b = node(random);
    if (std::abs(a - b) < 20) continue;
    Edge edge = graph->problem.edges.back();  // Information of a right one.
    edge.a = a;
    edge.b = b;
    edge.T_a_b = Pose::FromXyzRpy(metres(random), metres(random), 0.1 * metres(random),
                                  radians(random), radians(random), turn(random));
    graph->problem.edges.push_back(edge);
    --wanted;
  }
}

double AlignedRmse(const std::vector<Pose>& poses, const std::vector<Pose>& truth) {
  Eigen::Matrix3Xd from(3, poses.size()), to(3, poses.size());
  for (size_t i = 0; i < poses.size(); ++i) {
    from.col(static_cast<Eigen::Index>(i)) = poses[i].translation();
    to.col(static_cast<Eigen::Index>(i)) = truth[i].translation();
  }
  const Eigen::Matrix4d T = Eigen::umeyama(from, to, false);
  const Eigen::Matrix3Xd gap =
      ((T.topLeftCorner<3, 3>() * from).colwise() + T.topRightCorner<3, 1>().eval()) - to;
  return std::sqrt(gap.squaredNorm() / static_cast<double>(poses.size()));
}

}  // namespace isthmus::bench
