#include "server/main/config.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <set>
#include <vector>

#include "core/io/file_io.h"
#include "server/main/settings.h"

namespace isthmus::server {
namespace {

absl::Status Wrong(const YAML::Node& node, const std::string& what) {
  return absl::InvalidArgumentError(absl::StrCat("line ", node.Mark().line + 1, ": ", what));
}

std::string KnownKeys(const std::vector<Setting>& settings, const std::string& section) {
  std::vector<std::string> keys;
  for (const Setting& setting : settings) {
    if (setting.section == section) keys.push_back(setting.key);
  }
  return absl::StrJoin(keys, ", ");
}

std::string KnownSections(const std::vector<Setting>& settings) {
  std::vector<std::string> sections;
  for (const Setting& setting : settings) {
    if (sections.empty() || sections.back() != setting.section) sections.push_back(setting.section);
  }
  return absl::StrJoin(sections, ", ");
}

absl::Status ReadSection(const YAML::Node& node, const std::string& section,
                         const std::vector<Setting>& settings) {
  const std::string known = KnownKeys(settings, section);
  std::set<std::string> seen;
  for (const auto& entry : node) {
    const std::string key = entry.first.Scalar();
    const std::string name = absl::StrCat(section, ".", key);
    const auto setting = std::find_if(settings.begin(), settings.end(), [&](const Setting& s) {
      return s.section == section && s.key == key;
    });
    if (setting == settings.end()) {
      return Wrong(entry.first,
                   absl::StrCat("unknown setting ", name, ": ", section, " has ", known));
    }
    if (!seen.insert(key).second) {
      return Wrong(entry.first, absl::StrCat(name, " is given twice"));
    }
    if (!entry.second.IsScalar()) {
      return Wrong(entry.first, absl::StrCat(name, " must be a single value"));
    }
    const absl::Status status = setting->read(entry.second.Scalar());
    if (!status.ok()) {
      return Wrong(entry.first,
                   absl::StrCat(name, " is \"", entry.second.Scalar(), "\": ", status.message()));
    }
  }
  return absl::OkStatus();
}

absl::Status ReadSections(const YAML::Node& root, const std::vector<Setting>& settings) {
  if (root.IsNull()) return absl::OkStatus();  // An empty file: all defaults.
  if (!root.IsMap()) return Wrong(root, "the file must be sections with settings in them");
  std::set<std::string> seen;
  for (const auto& entry : root) {
    const std::string section = entry.first.Scalar();
    if (KnownKeys(settings, section).empty()) {
      return Wrong(entry.first, absl::StrCat("unknown section ", section, ": there are ",
                                             KnownSections(settings)));
    }
    if (!seen.insert(section).second) {
      return Wrong(entry.first, absl::StrCat("section ", section, " is given twice"));
    }
    if (entry.second.IsNull()) continue;
    if (!entry.second.IsMap()) {
      return Wrong(entry.first, absl::StrCat("section ", section, " must hold settings"));
    }
    absl::Status status = ReadSection(entry.second, section, settings);
    if (!status.ok()) return status;
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<ServerConfig> ParseConfig(const std::string& yaml) {
  ServerConfig config;
  try {
    absl::Status status = ReadSections(YAML::Load(yaml), SettingsOf(config));
    if (!status.ok()) return status;
  } catch (const YAML::Exception& error) {
    return absl::InvalidArgumentError(
        absl::StrCat("line ", error.mark.line + 1, ": not YAML: ", error.msg));
  }
  return config;
}

absl::StatusOr<ServerConfig> LoadConfig(const std::string& path) {
  const absl::StatusOr<std::string> yaml = io::ReadFile(path);
  if (!yaml.ok()) {
    return absl::NotFoundError(
        absl::StrCat("the configuration cannot be read: ", yaml.status().message()));
  }
  absl::StatusOr<ServerConfig> config = ParseConfig(*yaml);
  if (!config.ok()) {
    return absl::Status(config.status().code(),
                        absl::StrCat(path, ", ", config.status().message()));
  }
  return config;
}

std::string PrintConfig(const ServerConfig& config) {
  ServerConfig copy = config;
  std::string text;
  std::string section;
  for (const Setting& setting : SettingsOf(copy)) {
    if (setting.section != section) {
      absl::StrAppend(&text, section.empty() ? "" : "\n", setting.section, ":\n");
      section = setting.section;
    }
    absl::StrAppend(&text, "  # ", setting.comment, "\n  ", setting.key, ": ", setting.write(),
                    "\n");
  }
  return text;
}

}  // namespace isthmus::server
