// Typed identifiers, so that a robot's name can never be passed where a session is meant.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <utility>

namespace isthmus {

// A text identifier that is only comparable with its own kind. Regular value type; an empty one
// means "none".
template <typename Tag>
class TextId {
 public:
  TextId() = default;
  explicit TextId(std::string value) : value_(std::move(value)) {}

  const std::string& value() const { return value_; }
  bool empty() const { return value_.empty(); }

  friend auto operator<=>(const TextId&, const TextId&) = default;
  friend bool operator==(const TextId&, const TextId&) = default;

 private:
  std::string value_;
};

// The name a robot gives itself, e.g. "alice". Stable over days and sessions.
using RobotId = TextId<struct RobotIdTag>;
// One run of one robot with one odom frame, e.g. "alice-1". Chosen by the server.
using SessionId = TextId<struct SessionIdTag>;

// A submap is the index-th of its session, counted from 0.
struct SubmapId {
  SessionId session;
  uint32_t index = 0;

  friend auto operator<=>(const SubmapId&, const SubmapId&) = default;
  friend bool operator==(const SubmapId&, const SubmapId&) = default;
};

// "alice-1/7": the form used in logs, messages and the API.
std::string ToString(const SubmapId& id);

}  // namespace isthmus

template <typename Tag>
struct std::hash<isthmus::TextId<Tag>> {
  size_t operator()(const isthmus::TextId<Tag>& id) const {
    return std::hash<std::string>{}(id.value());
  }
};

template <>
struct std::hash<isthmus::SubmapId> {
  size_t operator()(const isthmus::SubmapId& id) const {
    return std::hash<std::string>{}(id.session.value()) * 31 + id.index;
  }
};
