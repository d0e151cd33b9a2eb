// The table of all settings.
#pragma once

#include <absl/status/status.h>

#include <functional>
#include <string>
#include <vector>

#include "server/main/config.h"

namespace isthmus::server {

struct Setting {
  std::string section;
  std::string key;
  std::string comment;  // One line: meaning, unit, consequence.
  // Sets the value from its text. InvalidArgument says what would be valid.
  std::function<absl::Status(const std::string&)> read;
  std::function<std::string()> write;  // The value as YAML.
};

// In the order of sections. The settings point into `config`, which must outlive them.
std::vector<Setting> SettingsOf(ServerConfig& config);

// "section.key" was a setting of an earlier version: a file may name it still.
bool WasSetting(const std::string& name);

}  // namespace isthmus::server
