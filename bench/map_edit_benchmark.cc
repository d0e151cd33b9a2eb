// The cost of the next view of a large map; see BENCHMARK.md.
#include <benchmark/benchmark.h>

#include <memory>
#include <string>

#include "server/map/map_edit.h"

namespace isthmus::server {
namespace {

SessionId Id(int session) { return SessionId("robot_" + std::to_string(1000 + session) + "-1"); }

MapEdit WithSubmap(int session, int index) {
  auto submap = std::make_shared<Submap>();
  submap->id = {Id(session), static_cast<uint32_t>(index)};
  submap->keyframes = {{1, 1, Pose()}};
  submap->points = {{1, 2, 3, 0, 0}};
  MapEdit edit;
  edit.batch.submaps = {submap};
  edit.batch.trajectory = {
      {Id(session), {uint64_t(index) + 1, index, Pose(), static_cast<uint32_t>(index)}}};
  edit.changes.causes = {"submap"};
  return edit;
}

// 10,000 submaps in so many sessions, each pair of which was compared.
std::shared_ptr<const MapView> MakeView(int sessions) {
  MapEdit all;
  for (int a = 0; a < sessions; ++a) {
    all.batch.sessions.emplace_back().id = Id(a);
    for (int i = 0; i < 10'000 / sessions; ++i) {
      const MapEdit one = WithSubmap(a, i);
      all.batch.submaps.push_back(one.batch.submaps.front());
      all.batch.trajectory.push_back(one.batch.trajectory.front());
    }
    for (int b = a + 1; b < sessions; ++b) {
      Match& match = all.batch.matches.emplace_back();
      match.a = Id(a);
      match.b = Id(b);
    }
  }
  return Apply(MapView(), all);
}

void AddsASubmap(benchmark::State& state) {
  const auto sessions = static_cast<int>(state.range(0));
  const auto view = MakeView(sessions);
  const MapEdit edit = WithSubmap(sessions / 2, 10'000 / sessions);
  const PreparedEdit prepared = Prepare(edit, *view);
  for (auto _ : state) benchmark::DoNotOptimize(Apply(*view, edit, prepared));
}
BENCHMARK(AddsASubmap)->ArgName("sessions")->Arg(1)->Arg(100);

void GoesThroughAllSubmaps(benchmark::State& state) {
  const auto view = MakeView(static_cast<int>(state.range(0)));
  for (auto _ : state) {
    size_t points = 0;
    for (const auto& [id, session] : view->sessions) {
      for (const auto& [index, submap] : session.submaps) points += submap.point_count;
    }
    benchmark::DoNotOptimize(points);
  }
}
BENCHMARK(GoesThroughAllSubmaps)->ArgName("sessions")->Arg(1)->Arg(100);

}  // namespace
}  // namespace isthmus::server
