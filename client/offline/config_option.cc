#include "client/offline/config_option.h"

#include "client/console/say.h"

namespace isthmus::cli {

void AddConfigOption(CLI::App& command, std::string& file) {
  command.add_option("--config", file,
                     "YAML file of settings of isthmus-server; without it the defaults");
}

absl::StatusOr<server::ServerConfig> LoadConfig(const std::string& file) {
  if (file.empty()) return server::ServerConfig();
  auto config = server::LoadConfig(file);
  if (!config.ok()) return config.status();
  for (const std::string& warning : config->warnings) Warn("isthmus: %s\n", warning);
  return config;
}

}  // namespace isthmus::cli
