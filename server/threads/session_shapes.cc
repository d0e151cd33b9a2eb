#include "server/threads/session_shapes.h"

namespace isthmus::server {

void SessionShapes::SetSizes(const SessionView& session, Ground* ground) {
  ground->submaps = session.submaps.size();
  ground->next_index = session.next_index();
  ground->finished = session.record.state == SessionState::kFinished;
}

std::set<SessionId> SessionShapes::FindOutdated(const MapView& view) {
  if (seen_ == view.serial) return {};
  const bool is_first = !seen_;
  seen_ = view.serial;
  std::map<SessionId, Ground> grounds;
  for (const auto& [id, state] : states_) grounds[id];
  for (const auto& [id, loop] : view.loops) {
    grounds[loop.session].loops.emplace_back(id, loop.rejected);
  }
  std::set<SessionId> outdated;
  for (auto& [id, ground] : grounds) {
    const SessionView* session = view.Find(id);
    if (session == nullptr) {
      states_.erase(id);
      continue;
    }
    SetSizes(*session, &ground);
    const auto [it, is_new] = states_.try_emplace(id);
    State& state = it->second;
    if (is_new && is_first) {
      state.had_loops = true;
      state.ground = ground;
    }
    if (state.left_out || state.ground == ground) continue;
    if (state.is_made || !state.had_loops) {
      outdated.insert(id);
      continue;
    }
    // It is not known how far that moves it.
    if (state.ground.loops != ground.loops) ++state.version;
    state.ground = ground;
  }
  return outdated;
}

void SessionShapes::Update(const MapView& view, const SessionId& session) {
  const SessionView* entry = view.Find(session);
  if (entry == nullptr) return;
  State& state = states_[session];
  Ground ground;
  SetSizes(*entry, &ground);
  std::vector<LoopClosure> loops;
  for (const auto& [id, loop] : view.loops) {
    if (loop.session != session) continue;
    ground.loops.emplace_back(id, loop.rejected);
    loops.push_back(loop);
  }
  const matching::SubmapList outlines = Outlines(*entry);
  if (!state.is_made && !state.had_loops) {
    // It was matched as odometry has it.
    state.keeper.Update(outlines, {}, ground.finished, nullptr);
  }
  const Placement* published = loops.empty() ? nullptr : view.PlacementOf(session);
  state.version += state.keeper.Update(outlines, loops, ground.finished, published);
  state.ground = std::move(ground);
  state.is_made = true;
}

void SessionShapes::LeaveOut(const SessionId& session) {
  State& state = states_[session];
  state.keeper = {};
  state.left_out = true;
  ++state.version;
}

std::map<SessionId, uint32_t> SessionShapes::versions() const {
  std::map<SessionId, uint32_t> versions;
  for (const auto& [id, state] : states_) versions.emplace_hint(versions.end(), id, state.version);
  return versions;
}

SessionShapes::Shaped SessionShapes::Of(const MapView& view, const SessionView& session) {
  const auto it = states_.find(session.record.id);
  if (it == states_.end() || it->second.left_out) return {Outlines(session), nullptr};
  if (!it->second.is_made) Update(view, session.record.id);
  return {it->second.keeper.submaps(), it->second.keeper.shape()};
}

matching::SubmapList SessionShapes::Outlines(const SessionView& session) {
  matching::SubmapList outlines;
  for (const auto& [index, submap] : session.submaps) {
    if (auto outline = outlines_(submap.id)) outlines.push_back(std::move(outline));
  }
  return outlines;
}

}  // namespace isthmus::server
