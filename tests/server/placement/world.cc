#include "tests/server/placement/world.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "server/placement/edge_information.h"
#include "server/placement/initial_poses.h"

namespace isthmus::placement {

Vector6d World::Noise(double position_m, double rotation_rad) {
  std::normal_distribution<double> normal;
  Vector6d noise;
  for (int i = 0; i < 6; ++i) noise[i] = (i < 3 ? position_m : rotation_rad) * normal(random_);
  return noise;
}

Session& World::AddRobot(const std::string& name, int count, int per_lap, double radius_m,
                         int first, const Stray& stray) {
  std::vector<Pose>& truth = truth_[name];
  Session session;
  session.tree.session = session.tree.reference = SessionId(name);
  Vector6d bias = Vector6d::Zero();
  bias[5] = stray.yaw_bias_rad;
  for (int k = 0; k < count; ++k) {
    const double angle = 2 * std::numbers::pi * (first + k) / per_lap;
    truth.push_back(Pose::FromXyzRpy(radius_m * std::cos(angle), radius_m * std::sin(angle),
                                     std::sin(2 * angle), 0, 0, angle + std::numbers::pi / 2));
    Node node;
    node.index = static_cast<uint32_t>(k);
    if (k > 0) {
      const size_t now = static_cast<size_t>(k);
      node.T_odom_submap = session.nodes.back().T_odom_submap *
                           (truth[now - 1].Inverse() * truth[now]) *
                           Exp(bias + Noise(stray.position_m, stray.rotation_rad));
      node.travelled_m = 2 * std::numbers::pi * radius_m / per_lap;
    }
    session.nodes.push_back(node);
  }
  input.sessions.push_back(session);
  std::sort(input.sessions.begin(), input.sessions.end(),
            [](const Session& a, const Session& b) { return a.tree.session < b.tree.session; });
  UpdateTrees();
  return Find(name);
}

SubmapEdge World::Measure(const std::string& a, uint32_t i, const std::string& b, uint32_t j) {
  const Pose T = Truth(a, i).Inverse() * Truth(b, j);
  return {i, j, Exp(Noise(0.01, 0.001)) * T, IsotropicInformation(0.01, 0.001)};
}

void World::AddLoop(const std::string& name, int a, int b) {
  LoopClosure loop;
  loop.id = next_loop_++;
  loop.session = SessionId(name);
  loop.submap_a = static_cast<uint32_t>(a);
  loop.submap_b = static_cast<uint32_t>(b);
  loop.edges = {Measure(name, loop.submap_a, name, loop.submap_b)};
  loop.T_a_b = loop.edges[0].T_a_b;
  input.loops.push_back(loop);
}

void World::AddFalseLoop(const std::string& name, int a, int b) {
  AddLoop(name, a, b);
  LoopClosure& loop = input.loops.back();
  loop.T_a_b = loop.edges[0].T_a_b = Exp(Noise(5, 0.5));
}

Match& World::AddMatch(const std::string& a, const std::string& b,
                       const std::vector<std::pair<uint32_t, uint32_t>>& pairs) {
  Match match;
  match.a = SessionId(a);
  match.b = SessionId(b);
  match.state = MatchState::kAccepted;
  match.reason = MatchReason::kOk;
  match.confidence = 0.9;
  for (const auto& [i, j] : pairs) match.edges.push_back(Measure(a, i, b, j));
  const auto odom = [this](const std::string& name, uint32_t index) {
    for (const Node& node : Find(name).nodes) {
      if (node.index == index) return node.T_odom_submap;
    }
    return Pose();
  };
  const SubmapEdge& edge = match.edges.front();
  match.T_a_b = odom(a, edge.submap_a) * edge.T_a_b * odom(b, edge.submap_b).Inverse();
  input.matches.push_back(match);
  UpdateTrees();
  return input.matches.back();
}

Match& World::ForceMatch(const std::string& a, const std::string& b, const Pose& T_a_b) {
  Match match;
  match.a = SessionId(a);
  match.b = SessionId(b);
  match.state = MatchState::kAccepted;
  match.reason = MatchReason::kByHand;
  match.matcher = GuessSource::kByHand;
  match.confidence = 1;
  match.T_a_b = T_a_b;
  input.matches.push_back(match);
  UpdateTrees();
  return input.matches.back();
}

void World::RemoveMatch(const std::string& a, const std::string& b) {
  std::erase_if(input.matches, [&](const Match& match) {
    return match.a == SessionId(a) && match.b == SessionId(b);
  });
  UpdateTrees();
}

void World::Retire(const std::string& name, uint32_t first, uint32_t last) {
  std::erase_if(Find(name).nodes,
                [&](const Node& node) { return node.index >= first && node.index <= last; });
}

void World::UpdateTrees() {
  std::vector<const Match*> matches;
  for (const Match& match : input.matches) matches.push_back(&match);
  std::stable_sort(matches.begin(), matches.end(),
                   [](const Match* a, const Match* b) { return a->confidence > b->confidence; });
  std::map<SessionId, Placement*> trees;
  for (Session& session : input.sessions) {
    session.tree.reference = session.tree.session;
    session.tree.T_map_odom = Pose();
    trees[session.tree.session] = &session.tree;
  }
  for (const Match* match : matches) {
    Placement& a = *trees.at(match->a);
    Placement& b = *trees.at(match->b);
    if (a.reference == b.reference) continue;
    const bool keep_a = a.reference < b.reference;
    const Pose T = keep_a ? a.T_map_odom * match->T_a_b * b.T_map_odom.Inverse()
                          : b.T_map_odom * match->T_a_b.Inverse() * a.T_map_odom.Inverse();
    const SessionId kept = keep_a ? a.reference : b.reference;
    const SessionId moved = keep_a ? b.reference : a.reference;
    for (auto& [id, tree] : trees) {
      if (tree->reference != moved) continue;
      tree->reference = kept;
      tree->T_map_odom = T * tree->T_map_odom;
    }
  }
  std::map<SessionId, uint32_t> components;
  for (auto& [id, tree] : trees) {
    tree->component =
        components.emplace(tree->reference, static_cast<uint32_t>(components.size())).first->second;
  }
}

const Pose& World::Truth(const std::string& name, uint32_t index) const {
  return truth_.at(name).at(index);
}

Session& World::Find(const std::string& name) {
  return *std::find_if(input.sessions.begin(), input.sessions.end(), [&](const Session& session) {
    return session.tree.session == SessionId(name);
  });
}

const Placement& PlacementOf(const std::vector<Placement>& placements, const std::string& name) {
  return *FindPlacement(placements, SessionId(name));
}

Pose PoseOf(const std::vector<Placement>& placements, const std::string& name, uint32_t index) {
  return *FindPose(PlacementOf(placements, name), index);
}

double Rmse(const World& world, const std::vector<Placement>& placements, const std::string& name) {
  const Placement& placement = PlacementOf(placements, name);
  const SubmapPose& first = placement.submaps.front();
  const Pose T = world.Truth(name, first.index) * first.T_map_submap.Inverse();
  double sum = 0;
  for (const SubmapPose& submap : placement.submaps) {
    sum += (T * submap.T_map_submap.translation() - world.Truth(name, submap.index).translation())
               .squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(placement.submaps.size()));
}

double LargestMove(const std::vector<Placement>& a, const std::vector<Placement>& b) {
  double largest = 0;
  for (const Placement& placement : a) {
    const Placement* other = FindPlacement(b, placement.session);
    if (other == nullptr) continue;
    for (const SubmapPose& submap : placement.submaps) {
      const Pose* pose = FindPose(*other, submap.index);
      if (pose == nullptr) continue;
      largest = std::max(largest, (pose->translation() - submap.T_map_submap.translation()).norm());
    }
  }
  return largest;
}

}  // namespace isthmus::placement
