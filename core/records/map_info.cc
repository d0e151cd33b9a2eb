#include "core/records/map_info.h"

#include <algorithm>

namespace isthmus {

std::optional<uint32_t> MapWith(const MapInfo& info, const SessionId& session) {
  for (const Component& component : info.components) {
    const auto& sessions = component.sessions;
    if (std::ranges::find(sessions, session) != sessions.end()) return component.component;
  }
  return std::nullopt;
}

absl::StatusOr<uint32_t> NumberIn(const MapInfo& info, const MapName& map) {
  return NumberOf(map, static_cast<uint32_t>(info.components.size()),
                  [&info](const SessionId& session) { return MapWith(info, session); });
}

}  // namespace isthmus
