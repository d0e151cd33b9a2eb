#include "core/map/map_name.h"

#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>

namespace isthmus {

MapName MapName::FromText(absl::string_view text) {
  uint32_t number = 0;
  return absl::SimpleAtoi(text, &number) ? MapName(number) : MapName(SessionId(std::string(text)));
}

std::string MapName::ToText() const {
  return session_.empty() ? absl::StrCat(number_) : session_.value();
}

absl::StatusOr<uint32_t> NumberOf(
    const MapName& name, uint32_t count,
    const std::function<std::optional<uint32_t>(const SessionId&)>& number_of) {
  if (name.session().empty()) {
    if (name.number() == 0 || name.number() < count) return name.number();
    return absl::NotFoundError(absl::StrCat("no map ", name.number(), ": there are ", count,
                                            ", counted from 0, the largest first"));
  }
  if (const std::optional<uint32_t> number = number_of(name.session())) return *number;
  return absl::NotFoundError(
      absl::StrCat("no map has the session \"", name.session().value(),
                   "\": it was deleted, or is not placed yet. Any session in a map names it; "
                   "`isthmus status` tells the maps"));
}

absl::Status CheckRobotIsIn(
    uint32_t wanted, const RobotId& robot, const std::vector<SessionId>& sessions,
    const std::function<std::optional<uint32_t>(const SessionId&)>& number_of) {
  std::optional<SessionId> elsewhere;
  for (const SessionId& session : sessions) {
    const std::optional<uint32_t> number = number_of(session);
    if (number == wanted) return absl::OkStatus();
    if (number) elsewhere = session;
  }
  if (!elsewhere) return absl::OkStatus();
  return absl::FailedPreconditionError(absl::StrCat("robot \"", robot.value(), "\" is not in map ",
                                                    wanted, " but in map ", *number_of(*elsewhere),
                                                    ": ask for the map ", elsewhere->value()));
}

}  // namespace isthmus
