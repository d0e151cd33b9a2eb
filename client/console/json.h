// JSON for scripts. An answer of the server is its message in protobuf's own mapping, with the
// names of the .proto: https://protobuf.dev/programming-guides/json
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "core/pose.h"
#include "core/records/map_graph.h"

namespace google::protobuf {
class Message;
}

namespace isthmus::cli {

using Json = nlohmann::ordered_json;

// Fields that are 0, false or empty are there; those that can be absent, like a message, only where
// they are not. Integers of 64 bits are numbers, but for a fixed64: that is a hash, and text.
Json ToJson(const google::protobuf::Message& message);
Json ToJson(const Pose& pose);
Json ToJson(const MatchEdge& edge);    // With the submaps that carry the match, where it has them.
Json ToJson(const Loop& loop);         // With its pairs of submaps, as a match.
Json ToJson(const MatchGraph& graph);  // As GetMatchGraphResponse, of all responses together.

// null for what is not known.
template <typename Value>
Json OrNull(const std::optional<Value>& value) {
  return value ? Json(*value) : Json(nullptr);
}

// The version of every document. It grows when a key goes or changes its meaning, not for new keys.
inline constexpr int kJsonVersion = 2;

// The document, an object, with "version" in front.
Json Versioned(const Json& document);
// Versioned, indented, with the last line's end.
std::string Text(const Json& document);
// To stdout, as Text has it.
void Print(const Json& document);
// Prints the document, Versioned, in one line, for documents that come one after the other.
void PrintLine(const Json& document);

}  // namespace isthmus::cli
