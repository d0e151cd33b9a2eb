#include "client/report/server_page.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <absl/strings/str_join.h>
#include <absl/time/clock.h>
#include <absl/time/time.h>

#include <algorithm>

#include "client/report/advice.h"
#include "client/report/page.h"
#include "client/report/server_tables.h"

namespace isthmus::report {
namespace {

void AddIfAny(const Table& table, const std::string& otherwise, Page* page) {
  if (!table.rows.empty()) {
    page->Add(table);
  } else if (!otherwise.empty()) {
    page->Paragraph(otherwise);
  }
}

// The figures of that kind, in a page's words.
absl::Status AddFigures(const std::vector<Figure>& figures, const std::string& folder,
                        const std::string& kind, const std::string& caption, Page* page) {
  for (const Figure& figure : figures) {
    if (figure["kind"] != kind) continue;
    const auto svg = InlineSvg(folder, figure["file"].get<std::string>());
    if (!svg.ok()) return svg.status();
    page->Figure(*svg, absl::StrCat(figure["title"].get<std::string>(), caption), kind == "map");
  }
  return absl::OkStatus();
}

void AddTiles(const ServerState& state, Page* page) {
  const auto accepted =
      std::count_if(state.graph.matches.begin(), state.graph.matches.end(),
                    [](const auto& edge) { return edge.match.state == MatchState::kAccepted; });
  page->Tiles({{absl::StrCat(state.info.robots.size()), "robots"},
               {absl::StrCat(state.info.components.size()),
                state.info.components.size() == 1 ? "map" : "maps, not joined"},
               {absl::StrCat(accepted, " of ", state.graph.matches.size()), "matches accepted"},
               {absl::StrCat(state.loops.size()), "loops closed"},
               {absl::StrCat(state.info.submaps), "submaps"},
               {absl::StrCat(state.info.revision), "revision"},
               {state.info.settled ? "settled" : "at work", "state"}});
}

void AddWaiting(const ServerState& state, Page* page) {
  page->Section("What is waiting, and what to do");
  const std::vector<Advice> waiting = WhatIsWaiting(state);
  for (const Advice& advice : waiting) page->Advice(advice.what, advice.todo);
  if (waiting.empty()) page->Paragraph("Nothing: all that came in is computed and in one map.");
}

void AddComponents(const ServerState& state, Page* page) {
  for (const Component& component : state.info.components) {
    page->Paragraph(absl::StrFormat(
        "Map %d: %s; %d points, in the frame of %s.", component.component,
        absl::StrJoin(component.robots, ", ",
                      [](std::string* out, const RobotId& robot) { out->append(robot.value()); }),
        component.point_count, component.reference.value()));
  }
}

}  // namespace

absl::StatusOr<std::string> ServerPage(const ServerState& state, const std::vector<Figure>& figures,
                                       const std::string& folder) {
  Page page("Isthmus map server", absl::StrCat(state.address, ", ",
                                               absl::FormatTime("%Y-%m-%d %H:%M:%S UTC",
                                                                absl::Now(), absl::UTCTimeZone())));
  AddTiles(state, &page);
  AddWaiting(state, &page);
  page.Section("Robots");
  AddIfAny(RobotsTable(state), "No robot has come yet.", &page);
  page.Section("Map");
  AddComponents(state, &page);
  absl::Status added = AddFigures(figures, folder, "map",
                                  ", from above; darker where points lie at many heights", &page);
  if (!added.ok()) return added;
  page.Section("What was joined, and why");
  added = AddFigures(figures, folder, "graph",
                     ": sessions in the colour of their map, with the reason and probability of "
                     "each match",
                     &page);
  if (!added.ok()) return added;
  AddIfAny(MatchesTable(state), "No two sessions were compared yet.", &page);
  AddIfAny(DecisionsTable(state), "", &page);
  page.Section("Loops");
  AddIfAny(LoopsTable(state), "No robot has come back to a place yet.", &page);
  page.Section("Revisions");
  AddIfAny(RevisionsTable(state), "The map has not changed yet.", &page);
  page.Section("Times");
  page.Add(TimesTable(state));
  return page.Html();
}

}  // namespace isthmus::report
