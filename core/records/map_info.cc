#include "core/records/map_info.h"

#include <algorithm>

namespace isthmus {

absl::StatusOr<uint32_t> NumberIn(const MapInfo& info, const MapName& map) {
  const auto number_of = [&info](const SessionId& session) -> std::optional<uint32_t> {
    for (const Component& component : info.components) {
      const auto& sessions = component.sessions;
      if (std::ranges::find(sessions, session) != sessions.end()) return component.component;
    }
    return std::nullopt;
  };
  return NumberOf(map, static_cast<uint32_t>(info.components.size()), number_of);
}

}  // namespace isthmus
