#include "server/main/open_map.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <system_error>
#include <utility>

#include "core/site_name.h"
#include "server/main/data_folder.h"
#include "server/main/log.h"
#include "storage/sqlite/sqlite_store.h"
#include "storage/upkeep/backup_stream.h"

namespace isthmus::server {
namespace {

namespace fs = std::filesystem;

// The folder of a site: `folder` for the default one, else a folder below it.
std::string FolderOf(const std::string& folder, const std::string& site) {
  return site == kDefaultSite ? folder : absl::StrCat(folder, "/sites/", site);
}

std::string JournalIn(const std::string& folder) { return folder + "/matching.journal"; }

using Warn = std::function<void(const std::string&)>;

// A data folder is of one server, also where the map is elsewhere.
absl::Status LockFolder(OpenMap* map) {
  auto lock = io::DirectoryLock::Acquire(map->folder);
  if (!lock.ok()) return lock.status();
  map->lock = *std::move(lock);
  return absl::OkStatus();
}

// Opens the store that the configuration names.
absl::StatusOr<std::unique_ptr<storage::MapStore>> OpenStore(const ServerConfig& config,
                                                             const SiteEvents& events,
                                                             const Warn& warn, OpenMap* map) {
  if (config.store.empty()) {
    if (absl::Status status = CheckMapIsHere(map->folder); !status.ok()) return status;
    storage::SqliteOptions options = config.storage;
    options.on_problem = warn;
    return storage::OpenSqliteStore(map->folder, options);
  }
  if (absl::Status status = LockFolder(map); !status.ok()) return status;
  std::error_code ignored;
  if (const std::string path = map->folder + "/isthmus.db"; fs::exists(path, ignored)) {
    warn(absl::StrCat("the map in ", path,
                      " is not served, because storage.store names a database. `isthmus copy` "
                      "copies a map to a database, or a site of it, that has none"));
  }
  auto store = OpenDatabaseMap(config, map->name, events, warn);
  if (!store.ok()) return store.status();
  if (absl::Status status = NoteMapIsIn(map->folder, config.store); !status.ok()) return status;
  return store;
}

// The pipeline of the map, which is this server's or, where the configuration says so, another's.
absl::StatusOr<std::unique_ptr<Pipeline>> OpenPipeline(const ServerConfig& config,
                                                       const SiteEvents& events,
                                                       const PipelineOptions& options,
                                                       OpenMap* map) {
  if (!config.replica) {
    auto store = OpenStore(config, events, options.on_problem, map);
    if (!store.ok()) return store.status();
    storage::RemoveAbandonedBackups(map->folder);
    return Pipeline::Open(options, *std::move(store));
  }
  if (absl::Status status = LockFolder(map); !status.ok()) return status;
  auto replica = OpenFollowedMap(config, map->name);
  if (!replica.ok()) return replica.status();
  if (absl::Status status = NoteMapIsIn(map->folder, config.store); !status.ok()) return status;
  return Pipeline::OpenReplica(options, std::move(replica->store), std::move(replica->follower));
}

// `map` says which; `sites`: how many there are.
absl::Status Open(const ServerConfig& config, const SiteEvents& events, PipelineOptions options,
                  size_t sites, OpenMap* map) {
  if (absl::Status status = MakeDataFolder(map->folder); !status.ok()) return status;
  const std::string site = map->name;
  const auto warn = [site](const std::string& text) {
    Log(spdlog::level::warn, text, LogFields{.site = site});
  };
  SetCache((static_cast<size_t>(config.cache_mb) << 20) / sites, map->folder, &options);
  const int threads = IngestThreads(config.pipeline.ingest_threads);
  const int shares = static_cast<int>(sites);
  options.ingest_threads = (threads + shares - 1) / shares;
  options.archive.directory = map->folder;
  options.crash_journal = JournalIn(map->folder);
  options.on_problem = warn;
  options.on_event = [site](const Event& event) {
    Log(spdlog::level::info, event.text, FieldsOf(event, site));
  };
  auto pipeline = OpenPipeline(config, events, options, map);
  if (!pipeline.ok()) return pipeline.status();
  map->pipeline = *std::move(pipeline);
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::vector<OpenMap>> OpenMaps(const std::string& folder, const ServerConfig& config,
                                              const SiteEvents& given) {
  const size_t count = 1 + config.sites.size();
  std::vector<std::string> journals = {JournalIn(folder)};
  for (const auto& [name, options] : config.sites) {
    journals.push_back(JournalIn(FolderOf(folder, name)));
  }
  SiteEvents events = given;
  events.on_lost = [journals, on_lost = given.on_lost](const std::string& why) {
    for (const std::string& journal : journals) Pipeline::ClearBlame(journal);
    if (on_lost) on_lost(why);
  };
  std::vector<OpenMap> maps(1);
  maps[0] = {kDefaultSite, folder, nullptr, nullptr};
  if (absl::Status status = Open(config, events, config.pipeline, count, &maps[0]); !status.ok()) {
    return status;
  }
  for (const auto& [name, options] : config.sites) {
    OpenMap map{name, FolderOf(folder, name), nullptr, nullptr};
    if (absl::Status status = Open(config, events, options, count, &map); !status.ok()) {
      return absl::Status(status.code(), absl::StrCat("site ", name, ": ", status.message()));
    }
    maps.push_back(std::move(map));
  }
  return maps;
}

}  // namespace isthmus::server
