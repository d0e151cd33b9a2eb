#include <algorithm>
#include <map>
#include <utility>

#include "server/map/map_edit.h"
#include "server/match_graph/cycles.h"
#include "server/match_graph/effective_match.h"
#include "server/match_graph/groups.h"

namespace isthmus::server {
namespace {

uint64_t CountSubmaps(const std::vector<SubmapId>& ids, const MapView& view) {
  return static_cast<uint64_t>(std::count_if(ids.begin(), ids.end(), [&](const SubmapId& id) {
    const SessionView* session = view.Find(id.session);
    return session != nullptr && session->submaps.contains(id.index);
  }));
}

void ApplyRecords(const MapEdit& edit, const storage::SubmapInfos& infos, MapView* view) {
  view->retired += CountSubmaps(edit.batch.retired, *view);
  storage::Apply(edit.batch, infos, view);
  if (!edit.removed_session) return;
  storage::RemoveSession(*edit.removed_session, view);
  ++view->removals;
}

}  // namespace

std::shared_ptr<const std::vector<Match>> EffectiveMatches(const MapView& view) {
  std::map<SessionPair, Match> combined;
  for (const auto& [pair, match] : view.matches) combined.emplace(pair, match);
  for (const auto& [pair, manual_decision] : view.manual_decisions) {
    const Match* computed = view.matches.Find(pair);
    combined[pair] = match_graph::EffectiveMatch(
        manual_decision, computed == nullptr ? std::nullopt : std::make_optional(*computed));
  }
  std::vector<Match> effective;
  for (auto& [pair, match] : combined) effective.push_back(std::move(match));
  const std::vector<match_graph::Node> nodes = MatchGraphNodes(view);
  match_graph::CheckCycles(nodes, match_graph::CycleOptions(), &effective);
  match_graph::SettleGroups(nodes, match_graph::GroupOptions(), &effective);
  return std::make_shared<const std::vector<Match>>(std::move(effective));
}

bool IsVoid(const MapEdit& edit, const MapView& view) {
  return std::any_of(edit.rests_on.begin(), edit.rests_on.end(),
                     [&](const SessionId& id) { return view.Find(id) == nullptr; });
}

bool ChangesMatches(const MapEdit& edit, const MapView& view) {
  const storage::WriteBatch& batch = edit.batch;
  if (!batch.matches.empty() || !batch.manual_decisions.empty() ||
      !batch.withdrawn_decisions.empty() || edit.removed_session) {
    return true;
  }
  return std::any_of(batch.submaps.begin(), batch.submaps.end(), [&](const auto& submap) {
    const SessionView* session = view.Find(submap->id.session);
    return session == nullptr || session->submaps.empty();
  });
}

PreparedEdit Prepare(const MapEdit& edit, const MapView& view) {
  PreparedEdit prepared{storage::SummarizeSubmaps(edit.batch)};
  if (ChangesMatches(edit, view)) {
    MapView changed = view;
    ApplyRecords(edit, prepared.infos, &changed);
    prepared.effective = EffectiveMatches(changed);
  }
  return prepared;
}

std::shared_ptr<const MapView> Apply(const MapView& view, const MapEdit& edit,
                                     const PreparedEdit& prepared) {
  auto next = std::make_shared<MapView>(view);
  ++next->serial;
  ApplyRecords(edit, prepared.infos, next.get());
  if (prepared.effective != nullptr) next->effective = prepared.effective;
  if (!edit.changes.causes.empty()) ++next->graph_version;
  if (edit.placed) {
    next->placed_version = edit.placed->version;
    if (edit.placed->revision != nullptr) next->revision = edit.placed->revision;
    next->tree = std::make_shared<const std::vector<SessionPair>>(edit.placed->tree);
    next->edge_status = std::make_shared<const placement::EdgeStatus>(edit.placed->edge_status);
  }
  if (edit.composed != nullptr) {
    if (edit.composed->waiting_submaps() == 0) {
      next->composed_revision = edit.composed->revision();
    }
    next->map = edit.composed;
  }
  return next;
}

std::shared_ptr<const MapView> Apply(const MapView& view, const MapEdit& edit) {
  return Apply(view, edit, Prepare(edit, view));
}

}  // namespace isthmus::server
