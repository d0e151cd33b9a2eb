// Groups of sessions whose matches are right as often as their confidence says, and wrong together
// where a robot's place has a twin.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>
#include <vector>

#include "server/match_graph/cycles.h"
#include "server/match_graph/groups.h"

namespace isthmus::match_graph {
namespace {

constexpr int kRobots = 8;
constexpr uint32_t kPlaces = 6;  // Places in each robot's map, 25 m apart.

class CalibratedWorld {
 public:
  explicit CalibratedWorld(uint32_t seed) : rng_(seed) {
    for (int i = 0; i < kRobots; ++i) {
      Node& node = nodes_.emplace_back();
      node.session = SessionId(std::string(1, static_cast<char>('a' + i)));
      for (uint32_t k = 0; k < kPlaces; ++k) node.submaps[k] = Eigen::Vector3d(25.0 * k, 0, 0);
      node.center = Eigen::Vector3d(62, 0, 0);
      node.extent_m = 125;
      T_world_odom_.push_back(Anywhere(80));
      for (uint32_t k = 0; k < kPlaces; ++k) traps_[i][k] = {Anywhere(60), Uniform(0, 1)};
    }
    for (int a = 0; a < kRobots; ++a) {
      for (int b = a + 1; b < kRobots; ++b) {
        if (Uniform(0, 1) < 0.9) AddMatch(a, b);
      }
    }
    CheckCycles(nodes_, CycleOptions(), &matches_);
  }

  void Settle() { SettleGroups(nodes_, GroupOptions(), &matches_); }

  bool AllInOneFrame() const {
    const std::vector<Placement> placements = Solve(nodes_, matches_, {}).placements;
    return std::all_of(placements.begin(), placements.end(),
                       [](const Placement& placement) { return placement.component == 0; });
  }

  // Pairs of robots that lie wrong in one frame.
  int CountWrong() const {
    const std::vector<Placement> placements = Solve(nodes_, matches_, {}).placements;
    int wrong = 0;
    for (int a = 0; a < kRobots; ++a) {
      for (int b = a + 1; b < kRobots; ++b) {
        const auto T_a_b = FindTransform(placements, nodes_[a].session, nodes_[b].session);
        if (!T_a_b) continue;
        const Pose off = TrueTransform(a, b).Inverse() * *T_a_b;
        wrong += off.translation().norm() > 3 || RotationAngle(off) > 0.1;
      }
    }
    return wrong;
  }

 private:
  // A robot at such a place is laid on its twin by all matches of a confidence below 1 - `at`.
  struct Trap {
    Pose T_off;
    double at = 0;
  };

  double Uniform(double from, double to) {
    return std::uniform_real_distribution<double>(from, to)(rng_);
  }
  Pose Anywhere(double size_m) {
    const double x = Uniform(-size_m, size_m) / 2, y = Uniform(-size_m, size_m) / 2;
    return Pose::FromXyzRpy(x, y, 0, 0, 0, Uniform(-3.14, 3.14));
  }
  Pose TrueTransform(int a, int b) const { return T_world_odom_[a].Inverse() * T_world_odom_[b]; }

  // Accepted from 0.98 on. A wrong one is by a twin, or by chance; half of the right ones are
  // among the rivals then.
  void AddMatch(int a, int b) {
    const auto place_a = static_cast<uint32_t>(rng_() % kPlaces);
    const auto place_b = static_cast<uint32_t>(rng_() % kPlaces);
    const double confidence = Uniform(0, 1) < 0.3 ? Uniform(0.98, 0.9999) : Uniform(0.1, 0.98);
    const bool by_twin = Uniform(0, 1) < 0.6, of_a = Uniform(0, 1) < 0.5;
    const Trap& trap = of_a ? traps_[a][place_a] : traps_[b][place_b];
    const bool wrong = (by_twin ? trap.at : Uniform(0, 1)) < 1 - confidence;
    const Pose noise =
        Pose::FromXyzRpy(Uniform(-0.1, 0.1), Uniform(-0.1, 0.1), 0, 0, 0, Uniform(-2e-3, 2e-3));
    const Pose right = TrueTransform(a, b);
    const Pose twin = of_a ? trap.T_off * right : right * trap.T_off;
    Match& match = matches_.emplace_back();
    match.a = nodes_[a].session;
    match.b = nodes_[b].session;
    match.T_a_b = (!wrong ? right : by_twin ? twin : Anywhere(80)) * noise;
    match.confidence = confidence;
    const bool accepted = confidence > 0.98;
    match.state = accepted ? MatchState::kAccepted : MatchState::kAmbiguous;
    match.reason = accepted ? MatchReason::kOk : MatchReason::kAmbiguous;
    match.edges = {{place_a, place_b, {}, Matrix6d::Identity()}};
    RivalMatch& rival = match.rivals.emplace_back();
    rival.T_a_b = wrong && Uniform(0, 1) < 0.5 ? right * noise : Anywhere(80);
    rival.state = MatchState::kAmbiguous;
    rival.reason = MatchReason::kAmbiguous;
    rival.confidence = (1 - confidence) / 2;
    rival.edges = match.edges;
  }

  std::mt19937 rng_;
  std::vector<Node> nodes_;
  std::vector<Pose> T_world_odom_;
  Trap traps_[kRobots][kPlaces];
  std::vector<Match> matches_;
};

TEST(CalibratedGroups, ManyMoreWorldsComeIntoOneFrameAndNoneIsMadeWrong) {
  int before = 0, after = 0, made_wrong = 0;
  for (uint32_t seed = 20'000; seed < 20'200; ++seed) {
    CalibratedWorld world(seed);
    before += world.AllInOneFrame();
    const int wrong = world.CountWrong();
    world.Settle();
    after += world.AllInOneFrame();
    made_wrong += wrong == 0 && world.CountWrong() > 0;
  }
  EXPECT_GT(after, 2 * before);
  EXPECT_GT(after, 150);
  EXPECT_EQ(made_wrong, 0);
  RecordProperty("before", before);
  RecordProperty("after", after);
  RecordProperty("made_wrong", made_wrong);
}

}  // namespace
}  // namespace isthmus::match_graph
