// The option --config: settings of a server, for commands that run one.
#pragma once

#include <absl/status/statusor.h>

#include <CLI/App.hpp>
#include <string>

#include "server/main/config.h"

namespace isthmus::cli {

void AddConfigOption(CLI::App& command, std::string& file);

// Settings of the file, or the defaults where its name is empty. Prints the file's warnings.
// InvalidArgument and NotFound as of server::LoadConfig.
absl::StatusOr<server::ServerConfig> LoadConfig(const std::string& file);

}  // namespace isthmus::cli
