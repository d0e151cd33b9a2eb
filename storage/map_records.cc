#include "storage/map_records.h"

#include <algorithm>
#include <map>
#include <utility>

namespace isthmus::storage {
namespace {

// The sessions that a batch changes, each copied once.
class ChangedSessions {
 public:
  explicit ChangedSessions(MapRecords* records) : records_(*records) {}
  ~ChangedSessions() {
    for (auto& [id, session] : changed_) records_.sessions.Set(id, std::move(session));
  }
  ChangedSessions(const ChangedSessions&) = delete;
  ChangedSessions& operator=(const ChangedSessions&) = delete;

  // Null for one that is not there.
  SessionRecords* Find(const SessionId& id) {
    if (const auto it = changed_.find(id); it != changed_.end()) return &it->second;
    const SessionRecords* known = records_.sessions.Find(id);
    return known == nullptr ? nullptr : &changed_.emplace(id, *known).first->second;
  }
  void Put(const SessionRecord& record) {
    SessionRecords* known = Find(record.id);
    (known != nullptr ? *known : changed_[record.id]).record = record;
  }

 private:
  MapRecords& records_;
  std::map<SessionId, SessionRecords> changed_;
};

void AddSubmaps(const SubmapInfos& infos, ChangedSessions* sessions) {
  for (const std::shared_ptr<const SubmapInfo>& info : infos) {
    SessionRecords* session = sessions->Find(info->id.session);
    if (session == nullptr) continue;
    session->points += info->point_count;
    session->submaps.Set(info->id.index, info);
  }
}

// The step to the first scan of a submap belongs to the one before.
void FollowPath(const WriteBatch& batch, ChangedSessions* sessions) {
  std::map<std::pair<SessionId, uint32_t>, double> lengths;
  for (const auto& [id, entry] : batch.trajectory) {
    SessionRecords* session = sessions->Find(id);
    if (session == nullptr) continue;
    const std::optional<TrajectoryEntry> last = std::exchange(session->last_pose, entry);
    // If a submap between the two was retired this is not the path that was driven.
    if (!last || entry.submap_index > last->submap_index + 1) continue;
    const double* known = session->path_length_m.Find(last->submap_index);
    double& length =
        lengths.try_emplace({id, last->submap_index}, known == nullptr ? 0 : *known).first->second;
    length += (entry.T_odom_sensor.translation() - last->T_odom_sensor.translation()).norm();
  }
  for (const auto& [key, length] : lengths) {
    sessions->Find(key.first)->path_length_m.Set(key.second, length);
  }
}

void PutMatches(const WriteBatch& batch, MapRecords* records) {
  const auto are_there = [records](const SessionId& a, const SessionId& b) {
    return records->sessions.contains(a) && records->sessions.contains(b);
  };
  for (const Match& match : batch.matches) {
    if (!are_there(match.a, match.b)) continue;
    Match kept = match;
    kept.cycle_m = kept.cycle_deg = -1;
    records->matches.Set({match.a, match.b}, std::move(kept));
  }
  for (const ManualDecision& manual_decision : batch.manual_decisions) {
    if (are_there(manual_decision.a, manual_decision.b))
      records->manual_decisions.Set({manual_decision.a, manual_decision.b}, manual_decision);
  }
  for (const SessionPair& pair : batch.withdrawn_decisions) records->manual_decisions.Erase(pair);
}

void PutLoopsAndAnchors(const WriteBatch& batch, MapRecords* records) {
  for (const LoopClosure& loop : batch.loops) {
    if (records->sessions.contains(loop.session)) records->loops.Set(loop.id, loop);
  }
  for (const Anchor& anchor : batch.anchors) {
    if (records->sessions.contains(anchor.submap.session)) {
      records->anchors.Set(anchor.submap, anchor);
    }
  }
  for (const SubmapId& submap : batch.removed_anchors) records->anchors.Erase(submap);
  if (batch.datum) records->datum = *batch.datum;
}

// True if no edge is left with both its submaps.
bool HasNoEdge(const LoopClosure& loop, const SessionRecords& session) {
  return std::none_of(loop.edges.begin(), loop.edges.end(), [&](const SubmapEdge& edge) {
    return session.submaps.contains(edge.submap_a) && session.submaps.contains(edge.submap_b);
  });
}

void Retire(const std::vector<SubmapId>& retired, MapRecords* records) {
  std::set<SessionId> touched;
  {
    ChangedSessions sessions(records);
    for (const SubmapId& id : retired) {
      SessionRecords* session = sessions.Find(id.session);
      const SubmapInfo* info = session == nullptr ? nullptr : session->submaps.Find(id.index);
      if (info == nullptr) continue;
      session->points -= info->point_count;
      session->submaps.Erase(id.index);
      session->path_length_m.Erase(id.index);
      records->anchors.Erase(id);
      touched.insert(id.session);
    }
  }
  if (touched.empty()) return;
  records->loops.EraseIf([&](uint64_t, const LoopClosure& loop) {
    return touched.contains(loop.session) && HasNoEdge(loop, *records->sessions.Find(loop.session));
  });
}

}  // namespace

SubmapInfos SummarizeSubmaps(const WriteBatch& batch) {
  SubmapInfos infos;
  for (const auto& submap : batch.submaps) {
    infos.push_back(std::make_shared<const SubmapInfo>(Summarize(*submap)));
  }
  return infos;
}

void Apply(const WriteBatch& batch, const SubmapInfos& infos, MapRecords* records) {
  {
    ChangedSessions sessions(records);
    for (const SessionRecord& record : batch.sessions) sessions.Put(record);
    AddSubmaps(infos, &sessions);
    FollowPath(batch, &sessions);
  }
  PutMatches(batch, records);
  PutLoopsAndAnchors(batch, records);
  Retire(batch.retired, records);
}

std::set<SessionId> RemoveSession(const SessionId& session, MapRecords* records) {
  std::set<SessionId> gone;
  records->sessions.EraseIf([&](const SessionId& id, const SessionRecords& records_of) {
    const bool goes = id == session || records_of.record.first_segment == session;
    if (goes) gone.insert(id);
    return goes;
  });
  const auto of_gone = [&gone](const SessionPair& pair, const auto&) {
    return gone.contains(pair.first) || gone.contains(pair.second);
  };
  records->matches.EraseIf(of_gone);
  records->manual_decisions.EraseIf(of_gone);
  records->loops.EraseIf(
      [&](uint64_t, const LoopClosure& loop) { return gone.contains(loop.session); });
  records->anchors.EraseIf(
      [&](const SubmapId& id, const Anchor&) { return gone.contains(id.session); });
  return gone;
}

}  // namespace isthmus::storage
