// Pose graphs whose truth is known, for tests.
#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "server/pose_graph/problem.h"

namespace isthmus::pose_graph {

// Standard deviations of measured relative poses, per axis.
struct EdgeNoise {
  double position_m = 0.02;
  double rotation_rad = 0.002;
  Matrix6d Information() const;
};

class GraphMaker {
 public:
  explicit GraphMaker(uint64_t seed) : random_(seed) {}

  // A uniform direction and an angle of up to `angle`, a translation of up to `distance` per axis.
  Pose RandomPose(double distance, double angle);
  Vector6d RandomTwist(double distance, double angle);
  // T_a_b of the truth, with noise drawn by `noise` and its information. Zero noise is none.
  Edge Measure(const std::vector<Pose>& truth, int a, int b, const EdgeNoise& noise,
               bool exact = false);

  std::mt19937_64& random() { return random_; }

 private:
  std::mt19937_64 random_;
};

// n nodes on a circle of the given radius that goes up and down a metre, looking ahead.
std::vector<Pose> Ring(int n, double radius);
// Laps of a block of streets side by side: `rows` x `columns` nodes, 10 m apart, row by row and
// back.
std::vector<Pose> Grid(int rows, int columns);

// Edges between consecutive nodes; the start of the search is what they add up to.
void AddOdometry(const std::vector<Pose>& truth, const EdgeNoise& noise, GraphMaker* maker,
                 Problem* problem, bool exact = false);
// Edges of neighbouring rows of a grid.
void AddRowLinks(const std::vector<Pose>& truth, int rows, int columns, const EdgeNoise& noise,
                 GraphMaker* maker, Problem* problem);

double LargestDistance(const std::vector<Pose>& a, const std::vector<Pose>& b);
// Root mean square of positions, first poses made to coincide.
double Rmse(const std::vector<Pose>& poses, const std::vector<Pose>& truth);

}  // namespace isthmus::pose_graph
