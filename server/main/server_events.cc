#include "server/main/server_events.h"

#include <absl/strings/str_cat.h>

#include <utility>

namespace isthmus::server {
namespace {

void NoteStartOf(Pipeline& pipeline, const std::string& version) {
  const auto before = pipeline.events().List(
      {.kinds = {EventKind::kServerStarted, EventKind::kServerStopped}, .limit = 1});
  const bool was_cut_off = before.ok() && !before->events.empty() &&
                           before->events.back().kind == EventKind::kServerStarted;
  Event event;
  event.kind = EventKind::kServerStarted;
  event.text = absl::StrCat("isthmus-server ", version, " started",
                            was_cut_off ? "; the one before it did not stop in order" : "");
  pipeline.events().Note(std::move(event));
}

}  // namespace

void LogToAllSites(const std::vector<OpenMap>& maps, EventKind kind, const std::string& text) {
  Event event;
  event.kind = kind;
  event.text = text;
  for (const OpenMap& map : maps) map.pipeline->events().Note(event);
}

void NoteStart(const std::vector<OpenMap>& maps, const std::string& version) {
  for (const OpenMap& map : maps) NoteStartOf(*map.pipeline, version);
}

}  // namespace isthmus::server
