// The server's answers as JSON, for scripts. Keys are those of the API's fields; poses are
// {"translation": [x, y, z], "rotation": [x, y, z, w]}. docs/cli.md shows every document.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "core/records/map_graph.h"
#include "core/records/map_info.h"
#include "core/records/map_reading.h"
#include "core/records/server_status.h"
#include "core/records/session_status.h"

namespace isthmus::cli {

using Json = nlohmann::ordered_json;

Json ToJson(const Pose& pose);
Json ToJson(const Box& box);
Json ToJson(const SubmapEdge& edge);
Json ToJson(const ScanCounts& scans);
Json ToJson(const SessionStatus& session);
Json ToJson(const MapInfo& info);
Json ToJson(const ServerStatus& status);
// `with_edges`: with the submaps that carry the match, as "edges".
Json ToJson(const MatchEdge& edge, bool with_edges = false);
Json ToJson(const MatchGraph& graph, bool with_edges = false);

// The version of every document. It grows when a key goes or changes its meaning, not for new keys.
inline constexpr int kJsonVersion = 1;

// The document, an object, with "version" in front.
Json Versioned(const Json& document);
// Versioned, indented, with the last line's end.
std::string Text(const Json& document);
// To stdout, as Text has it.
void Print(const Json& document);
// Prints the document, Versioned, in one line, for documents that come one after the other.
void PrintLine(const Json& document);

}  // namespace isthmus::cli
