// Robots that drive in circles and stray, for tests: the placer's input, and the truth.
#pragma once

#include <cstdint>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "server/placement/placer.h"

namespace isthmus::placement {

// The drift of odometry per submap: at random, and always to the same side.
struct Stray {
  double position_m = 0.005;
  double rotation_rad = 0.0005;
  double yaw_bias_rad = 0.001;
};

class World {
 public:
  explicit World(uint64_t seed) : random_(seed) {}

  // A session of `count` submaps, `per_lap` in a lap of a ring of that radius, beginning with the
  // submap `first` of the ring. Its odom frame is where it begins. Alone in a component.
  Session& AddRobot(const std::string& name, int count, int per_lap, double radius_m, int first = 0,
                    const Stray& stray = {});
  // The newer submap b seen from the older a, right but for a centimetre.
  void AddLoop(const std::string& name, int a, int b);
  // The same, but metres away from the truth.
  void AddFalseLoop(const std::string& name, int a, int b);
  // Accepted, with edges between these submaps of the two robots (in order of name); T_a_b is what
  // the first edge says. Puts b, and what hangs on it, into the component of a.
  Match& AddMatch(const std::string& a, const std::string& b,
                  const std::vector<std::pair<uint32_t, uint32_t>>& pairs);
  // Adds a match with a transform that is not true, given by hand.
  Match& ForceMatch(const std::string& a, const std::string& b, const Pose& T_a_b);
  void RemoveMatch(const std::string& a, const std::string& b);
  void Retire(const std::string& name, uint32_t first, uint32_t last);

  // Trees as match_graph would give: the first session of each component is the reference.
  void UpdateTrees();

  const Pose& Truth(const std::string& name, uint32_t index) const;
  Session& Find(const std::string& name);
  SubmapEdge Measure(const std::string& a, uint32_t i, const std::string& b, uint32_t j);

  Input input;

 private:
  Vector6d Noise(double position_m, double rotation_rad);

  std::mt19937_64 random_;
  std::map<std::string, std::vector<Pose>> truth_;  // By number of submap.
  uint64_t next_loop_ = 1;
};

// Root mean square of positions of one session, its first submap made to lie where it is in truth.
double Rmse(const World& world, const std::vector<Placement>& placements, const std::string& name);
// The largest difference of positions of submaps that are in both.
double LargestMove(const std::vector<Placement>& a, const std::vector<Placement>& b);
const Placement& PlacementOf(const std::vector<Placement>& placements, const std::string& name);
Pose PoseOf(const std::vector<Placement>& placements, const std::string& name, uint32_t index);

}  // namespace isthmus::placement
