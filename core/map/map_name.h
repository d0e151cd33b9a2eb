// A name of one of the maps that a server has.
#pragma once

#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/ids.h"

namespace isthmus {

// Any session in a map names it, whatever comes beside it, and goes on naming it where it merges
// with another. Its number is a place in an order by size: who brings more sessions takes it. A
// name is none of the numbers, as a session's id has a dash.
class MapName {
 public:
  // NOLINTNEXTLINE(google-explicit-constructor): a number may stand wherever a name may.
  MapName(uint32_t number = 0) : number_(number) {}
  explicit MapName(SessionId session) : session_(std::move(session)) {}
  // A number where the text is one, else a session.
  static MapName FromText(absl::string_view text);

  const SessionId& session() const { return session_; }  // Empty: the number counts.
  uint32_t number() const { return number_; }            // 0 is the largest map.
  std::string ToText() const;

  friend bool operator==(const MapName&, const MapName&) = default;

 private:
  SessionId session_;
  uint32_t number_ = 0;
};

// The number that the map has among `count` ones, of which `number_of` tells in which a session
// lies. NotFound, saying how to name one, where there is none; 0 may be asked of no maps, too.
absl::StatusOr<uint32_t> NumberOf(
    const MapName& name, uint32_t count,
    const std::function<std::optional<uint32_t>(const SessionId&)>& number_of);

// FailedPrecondition, naming its map, where the robot of these sessions is in others than number
// `wanted` alone. OK also where it is in none yet.
absl::Status CheckRobotIsIn(
    uint32_t wanted, const RobotId& robot, const std::vector<SessionId>& sessions,
    const std::function<std::optional<uint32_t>(const SessionId&)>& number_of);

}  // namespace isthmus
