#include "server/main/config.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <set>
#include <vector>

#include "core/io/file_io.h"
#include "core/site_name.h"
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
                         const std::vector<Setting>& settings, ServerConfig& config) {
  const std::string known = KnownKeys(settings, section);
  std::set<std::string> seen;
  for (const auto& entry : node) {
    const std::string key = entry.first.Scalar();
    const std::string name = absl::StrCat(section, ".", key);
    const std::string place = absl::StrCat("line ", entry.first.Mark().line + 1);
    const auto setting = std::find_if(settings.begin(), settings.end(), [&](const Setting& s) {
      return s.section == section && s.key == key;
    });
    if (setting == settings.end() && WasSetting(name)) {
      config.warnings.push_back(
          absl::StrCat(place, ": ", name, " is no longer a setting and does nothing: remove it"));
      continue;
    }
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
      // A URL may have a secret in it, which is why it is refused.
      const std::string& text = entry.second.Scalar();
      const bool is_url = text.find("://") != std::string::npos;
      const std::string value = is_url ? "a URL" : absl::StrCat("\"", text, "\"");
      return Wrong(entry.first, absl::StrCat(name, " is ", value, ": ", status.message()));
    }
    config.places[name] = place;
  }
  return absl::OkStatus();
}

// Into the config that the settings are of, but for the section `skipped`.
absl::Status ReadSections(const YAML::Node& root, const std::vector<Setting>& settings,
                          ServerConfig& config, const std::string& skipped = "") {
  if (root.IsNull()) return absl::OkStatus();  // An empty file: all defaults.
  if (!root.IsMap()) return Wrong(root, "it must consist of sections with settings");
  std::set<std::string> seen;
  for (const auto& entry : root) {
    const std::string section = entry.first.Scalar();
    if (section != skipped && KnownKeys(settings, section).empty()) {
      return Wrong(entry.first,
                   absl::StrCat("unknown section ", section, ": there are ",
                                KnownSections(settings), skipped.empty() ? "" : ", ", skipped));
    }
    if (!seen.insert(section).second) {
      return Wrong(entry.first, absl::StrCat("section ", section, " is given twice"));
    }
    if (section == skipped) continue;
    if (entry.second.IsNull()) continue;
    if (!entry.second.IsMap()) {
      return Wrong(entry.first, absl::StrCat("section ", section, " must hold settings"));
    }
    absl::Status status = ReadSection(entry.second, section, settings, config);
    if (!status.ok()) return status;
  }
  return absl::OkStatus();
}

// Settings that a site may have of its own. The rest is of the server as a whole.
std::vector<Setting> SettingsOfSite(ServerConfig& config) {
  std::vector<Setting> settings = SettingsOf(config);
  std::erase_if(settings, [](const Setting& setting) {
    return setting.section == "network" || setting.section == "metrics" ||
           setting.section == "web" || setting.section == "storage" || setting.section == "ingest";
  });
  return settings;
}

// Reads the sites. Other settings of the file are in `config` already, and hold for each site.
absl::Status ReadSites(const YAML::Node& sites, ServerConfig& config) {
  if (sites.IsNull()) return absl::OkStatus();
  if (!sites.IsMap())
    return Wrong(sites, "sites must be names with settings of their own, as NAME: {}");
  for (const auto& entry : sites) {
    const std::string name = entry.first.Scalar();
    if (absl::Status status = CheckSiteName(name); !status.ok()) {
      return Wrong(entry.first, std::string(status.message()));
    }
    if (name == kDefaultSite) {
      return Wrong(entry.first, "\"default\" is the site of the data folder itself: give another");
    }
    ServerConfig site = config;
    const absl::Status status = ReadSections(entry.second, SettingsOfSite(site), site);
    config.warnings = site.warnings;
    if (!status.ok()) {
      return absl::InvalidArgumentError(absl::StrCat("site ", name, ", ", status.message()));
    }
    if (!config.sites.emplace(name, site.pipeline).second) {
      return Wrong(entry.first, absl::StrCat("site ", name, " is given twice"));
    }
  }
  return absl::OkStatus();
}

// Only settings that differ from the rest of the file.
std::string PrintSites(const ServerConfig& config) {
  std::string text =
      "\n# Further maps, each in DIR/sites/NAME; instead of {}, give the settings that differ from "
      "the above.\n";
  if (config.sites.empty()) return text + "# sites:\n#   NAME: {}\n";
  text += "sites:\n";
  for (const auto& [name, pipeline] : config.sites) {
    ServerConfig whole = config, site = config;
    site.pipeline = pipeline;
    const std::vector<Setting> common = SettingsOfSite(whole), own = SettingsOfSite(site);
    std::string changed, section;
    for (size_t k = 0; k < own.size(); ++k) {
      if (own[k].write() == common[k].write()) continue;
      if (own[k].section != section) absl::StrAppend(&changed, "    ", own[k].section, ":\n");
      section = own[k].section;
      absl::StrAppend(&changed, "      ", own[k].key, ": ", own[k].write(), "\n");
    }
    absl::StrAppend(&text, "  ", name, changed.empty() ? ": {}\n" : ":\n", changed);
  }
  return text;
}

// Null where there is none.
absl::StatusOr<YAML::Node> OnlyDocument(const std::string& yaml) {
  const std::vector<YAML::Node> documents = YAML::LoadAll(yaml);
  for (size_t k = 1; k < documents.size(); ++k) {
    if (documents[k].IsNull()) continue;
    return Wrong(documents[k],
                 "a second document begins here, of which nothing would be read: remove the line "
                 "--- before it");
  }
  return documents.empty() ? YAML::Node() : documents.front();
}

}  // namespace

absl::StatusOr<ServerConfig> ParseConfig(const std::string& yaml) {
  ServerConfig config;
  try {
    const absl::StatusOr<YAML::Node> read = OnlyDocument(yaml);
    if (!read.ok()) return read.status();
    const YAML::Node& root = *read;
    absl::Status status = ReadSections(root, SettingsOf(config), config, "sites");
    if (status.ok() && root.IsMap() && root["sites"]) status = ReadSites(root["sites"], config);
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
  for (std::string& warning : config->warnings) warning = absl::StrCat(path, ", ", warning);
  for (auto& [setting, place] : config->places) place = absl::StrCat(path, ", ", place);
  return config;
}

absl::Status AtPlace(const ServerConfig& config, const std::string& setting,
                     const absl::Status& status) {
  const auto place = config.places.find(setting);
  if (status.ok() || place == config.places.end()) return status;
  return absl::Status(status.code(), absl::StrCat(place->second, ": ", status.message()));
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
  return text + PrintSites(config);
}

}  // namespace isthmus::server
