// The map as another server writes it, shown step by step.
#include <algorithm>
#include <set>
#include <utility>

#include "core/concurrency/mutex.h"
#include "server/map/map_writer.h"

namespace isthmus::server {
namespace {

// Sessions that are not there any more, and those whose id another one has by now.
std::vector<SessionId> GoneSessions(const storage::StoreDelta& delta, const MapView& view) {
  std::vector<SessionId> gone;
  if (!delta.sessions) return gone;
  std::set<std::pair<SessionId, int64_t>> there;
  for (const SessionRecord& record : *delta.sessions) there.emplace(record.id, record.created_ns);
  for (const auto& [id, session] : view.sessions) {
    if (!there.contains({id, session.record.created_ns})) gone.push_back(id);
  }
  return gone;
}

std::vector<SubmapId> GoneSubmaps(const storage::StoreDelta& delta, const MapView& view) {
  std::vector<SubmapId> gone;
  if (!delta.remaining) return gone;
  for (const auto& [id, session] : view.sessions) {
    for (const auto& [index, submap] : session.submaps) {
      if (!delta.remaining->contains(submap.id)) gone.push_back(submap.id);
    }
  }
  return gone;
}

// Takes out all that is gone; its submaps.
std::vector<SubmapId> RemoveGone(const storage::StoreDelta& delta, MapView* view) {
  std::vector<SubmapId> gone;
  const MapView before = *view;
  for (const SessionId& id : GoneSessions(delta, before)) {
    for (const auto& [index, submap] : before.Find(id)->submaps) gone.push_back(submap.id);
    storage::RemoveSession(id, view);
    ++view->removals;
  }
  const std::vector<SubmapId> retired = GoneSubmaps(delta, *view);
  storage::Apply({.retired = retired}, {}, view);
  view->retired += retired.size();
  gone.insert(gone.end(), retired.begin(), retired.end());
  return gone;
}

// As ChangesMatches of an edit.
bool ChangesMatches(const storage::StoreDelta& delta, const MapView& view) {
  if (delta.sessions || delta.matches || delta.manual_decisions) return true;
  return std::any_of(delta.submaps.begin(), delta.submaps.end(), [&](const SubmapInfo& submap) {
    const SessionView* session = view.Find(submap.id.session);
    return session == nullptr || session->submaps.empty();
  });
}

// True if placing would have other edges than it had.
bool ChangesGraph(const storage::StoreDelta& delta) {
  return delta.matches || delta.manual_decisions || delta.loops || delta.anchors || delta.revision;
}

// Tables that come whole replace the old ones.
void ApplyTables(const storage::StoreDelta& delta, const storage::SubmapInfos& infos,
                 MapView* view) {
  storage::WriteBatch batch;
  if (delta.sessions) batch.sessions = *delta.sessions;
  batch.trajectory = delta.trajectory;
  if (delta.matches) {
    view->matches = {};
    batch.matches = *delta.matches;
  }
  if (delta.manual_decisions) {
    view->manual_decisions = {};
    batch.manual_decisions = *delta.manual_decisions;
  }
  if (delta.loops) {
    view->loops = {};
    batch.loops = *delta.loops;
  }
  if (delta.anchors) {
    view->anchors = {};
    batch.anchors = *delta.anchors;
  }
  batch.datum = delta.datum;
  storage::Apply(batch, infos, view);
}

}  // namespace

storage::SubmapInfos MapWriter::MendedSubmaps(const storage::StoreDelta& delta) {
  storage::SubmapInfos infos;
  const View now = view();
  for (SubmapInfo info : delta.submaps) {
    Pose before;
    if (!infos.empty() && infos.back()->id.session == info.id.session) {
      before = infos.back()->T_odom_submap;
    } else if (const SessionView* known = now->Find(info.id.session);
               known != nullptr && !known->submaps.empty()) {
      before = known->submaps.back().T_odom_submap;
    }
    MendPose(before, &info);
    infos.push_back(std::make_shared<const SubmapInfo>(std::move(info)));
  }
  return infos;
}

void MapWriter::ShowDelta(const storage::StoreDelta& delta) {
  const View before = view();
  MapView changed = *before;
  const std::vector<SubmapId> gone = RemoveGone(delta, &changed);
  ApplyTables(delta, MendedSubmaps(delta), &changed);
  if (ChangesMatches(delta, *before)) changed.effective = EffectiveMatches(changed);
  if (delta.revision) changed.revision = std::make_shared<const MapRevision>(*delta.revision);
  if (ChangesGraph(delta)) ++changed.graph_version;
  for (const SubmapId& id : gone) cache_->Forget(id);
  {
    MutexLock editing(&editing_);
    // Results that placing and composing have shown meanwhile are not in the changes.
    const View now = view();
    changed.serial = now->serial + 1;
    changed.placed_version = now->placed_version;
    changed.tree = now->tree;
    changed.edge_status = now->edge_status;
    changed.map = now->map;
    changed.composed_revision = now->composed_revision;
    MutexLock lock(&mutex_);
    view_ = std::make_shared<const MapView>(std::move(changed));
  }
  const std::set<SubmapId> all_gone(gone.begin(), gone.end());
  activity_->ForgetDamage([&](const SubmapId& id) { return all_gone.contains(id); });
  changed_.Notify();
  activity_->changed().Notify();
}

}  // namespace isthmus::server
