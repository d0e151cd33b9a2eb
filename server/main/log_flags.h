// The flags of the log, alike in every program that writes one.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "server/main/log.h"

namespace isthmus::server {

inline void AddLogOptions(CLI::App& app, LogOptions& log) {
  app.add_option("--log-level", log.level, "How much the log says")
      ->check(CLI::IsMember({"debug", "info", "warn", "error", "off"}))
      ->capture_default_str();
  app.add_option_function<std::string>(
         "--log-format", [&log](const std::string& format) { log.json = format == "json"; },
         "Lines for people, or a JSON object a line")
      ->check(CLI::IsMember({"text", "json"}))
      ->default_str("text");
  app.add_option("--log-file", log.file,
                 "File to write the log to, in place of stderr; SIGHUP opens it anew");
}

}  // namespace isthmus::server
