// The server's log: one line for each event that its operator should know, for eyes or for
// programs.
#pragma once

#include <absl/status/status.h>
#include <spdlog/common.h>

#include <cstdint>
#include <optional>
#include <string>

#include "core/records/event.h"
#include "server/rpc/ended_call.h"

namespace isthmus::server {

struct LogOptions {
  std::string level = "info";  // "debug", "info", "warn", "error" or "off".
  bool json = false;           // An object a line; else text.
  std::string file = {};       // Path of a file to append to; empty: stderr.
};

// The subject of a line, as far as it is known; empty fields: unknown.
struct LogFields {
  std::string site = {};  // The default site's name is left out of text.
  std::string robot = {}, session = {};
  std::optional<uint64_t> sequence = {};  // A scan's.
  std::string event = {};                 // The kind of an event in the event log.
  std::string rpc = {}, code = {};        // A failed call's.
  std::string request_id = {}, peer = {}, token = {};
};

LogFields FieldsOf(const Event& event, const std::string& site);
LogFields FieldsOf(const rpc::FailedCall& call);

// The default logger of spdlog writes so from now on. Call once, before any thread. NotFound,
// PermissionDenied and the like where the file cannot be opened.
absl::Status StartLogging(const LogOptions& options);
// Handles a SIGHUP, which programs that rotate logs send: opens the file anew, by its name, or goes
// on with the one it has; says what it did. Not thread safe.
void OnHangup();

// Thread safe. Also spdlog::info and the like may be used, for lines without fields.
void Log(spdlog::level::level_enum level, const std::string& message, const LogFields& fields);

// A line with its end, whatever the strings hold: control characters are escaped. In text, the
// fields of a call stand behind the message, in parentheses.
std::string FormatLine(bool json, spdlog::level::level_enum level, int64_t time_ns,
                       const std::string& message, const LogFields& fields);

}  // namespace isthmus::server
