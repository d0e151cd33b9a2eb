// The frame of a program that runs until it is told to stop: its command line, log and last resort.
#pragma once

#include <absl/status/status.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <functional>
#include <iostream>
#include <optional>
#include <string>
#include <vector>

#include "core/caught.h"
#include "core/command_line/checks.h"
#include "server/main/log.h"

namespace isthmus::server {

inline void AddLogOptions(CLI::App& app, LogOptions& log) {
  app.add_option("--log-level", log.level, "Lowest level of logged messages")
      ->check(CLI::IsMember({"debug", "info", "warn", "error", "off"}))
      ->capture_default_str();
  app.add_option_function<std::string>(
         "--log-format", [&log](const std::string& format) { log.json = format == "json"; },
         "Lines for people, or one JSON object per line")
      ->check(CLI::IsMember({"text", "json"}))
      ->default_str("text");
  app.add_option("--log-file", log.file, "File for the log instead of stderr; SIGHUP reopens it");
}

// The exit code for a command line, or a configuration, that is wrong.
inline constexpr int kUsage = 2;

// `check` says after parsing what else is wrong, and may throw what CLI11 throws; then, also where
// help was asked for, the code to exit with.
inline std::optional<int> ParseArguments(
    CLI::App& app, int argc, const char* const* argv, const std::function<void()>& check = [] {}) {
  const auto require = [](const absl::Status& status) {
    if (!status.ok()) throw CLI::ValidationError(std::string(status.message()));
  };
  const std::vector<std::string> words = Words(argc, argv);
  try {
    require(CheckText(words));
    app.parse(argc, argv);
    require(CheckValues(words, app));
    check();
    return std::nullopt;
  } catch (const CLI::ParseError& error) {
    return app.exit(error, std::cout, std::cerr) == 0 ? 0 : kUsage;
  }
}

// Says why, and returns the code.
inline int Fail(int code, const absl::Status& status) {
  spdlog::error("{}", std::string(status.message()));
  return code;
}

// The exit code of `run`, with a log; `failed` where it throws.
inline int RunProgram(const std::string& name, const LogOptions& log, int failed,
                      const std::function<int()>& run) {
  if (const absl::Status logs = StartLogging(log); !logs.ok()) {
    std::fprintf(stderr, "%s: %s\n", name.c_str(), std::string(logs.message()).c_str());
    return kUsage;
  }
  try {
    return run();
  } catch (...) {
    return Fail(failed, CaughtStatus());
  }
}

}  // namespace isthmus::server
