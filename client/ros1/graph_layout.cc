#include "client/ros1/graph_layout.h"

#include <utility>

namespace isthmus::ros1 {
namespace {

// The means of the submaps' origins in their odom frames.
std::map<SessionId, Eigen::Vector3d> MiddlesInOdom(const std::vector<SubmapStatus>& submaps) {
  std::map<SessionId, std::pair<Eigen::Vector3d, size_t>> sums;
  for (const SubmapStatus& submap : submaps) {
    auto& [sum, count] =
        sums.try_emplace(submap.info.id.session, Eigen::Vector3d::Zero(), 0).first->second;
    sum += submap.info.T_odom_submap.translation();
    ++count;
  }
  std::map<SessionId, Eigen::Vector3d> middles;
  for (const auto& [session, sum] : sums) {
    middles[session] = sum.first / static_cast<double>(sum.second);
  }
  return middles;
}

struct Guess {
  Pose T_map_odom;
  double confidence = -1;
};

// Places of the other sessions, by the likeliest undecided matches with placed ones.
std::map<SessionId, Guess> GuessOthers(const MatchGraph& graph,
                                       const std::map<SessionId, Pose>& placed) {
  std::map<SessionId, Guess> guesses;
  for (const MatchEdge& edge : graph.matches) {
    const Match& match = edge.match;
    const auto a = placed.find(match.a), b = placed.find(match.b);
    if (!IsUndecided(match) || (a == placed.end()) == (b == placed.end())) continue;
    const bool from_a = a != placed.end();
    Guess& guess = guesses[from_a ? match.b : match.a];
    if (match.confidence <= guess.confidence) continue;
    guess = {from_a ? a->second * match.T_a_b : b->second * match.T_a_b.Inverse(),
             match.confidence};
  }
  return guesses;
}

}  // namespace

bool IsUndecided(const Match& match) {
  // Without a guess behind it, T_a_b says nothing.
  return (match.state == MatchState::kAmbiguous || match.state == MatchState::kNotYet) &&
         match.matcher != GuessSource::kNone;
}

std::map<SessionId, GraphNode> LayOut(const MatchGraph& graph,
                                      const std::vector<SubmapStatus>& submaps,
                                      uint32_t component) {
  std::map<SessionId, Pose> placed;
  for (const PlacedSession& session : graph.placements) {
    if (session.placement.component != component) continue;
    placed.emplace(session.placement.session, session.placement.T_map_odom);
  }
  const std::map<SessionId, Eigen::Vector3d> middles = MiddlesInOdom(submaps);
  const auto middle_of = [&middles](const SessionId& session) -> Eigen::Vector3d {
    const auto found = middles.find(session);
    return found != middles.end() ? found->second : Eigen::Vector3d::Zero();
  };
  std::map<SessionId, GraphNode> nodes;
  for (const auto& [session, T_map_odom] : placed) {
    nodes.emplace(session, GraphNode{T_map_odom * middle_of(session), true});
  }
  for (const auto& [session, guess] : GuessOthers(graph, placed)) {
    nodes.emplace(session, GraphNode{guess.T_map_odom * middle_of(session), false});
  }
  return nodes;
}

}  // namespace isthmus::ros1
