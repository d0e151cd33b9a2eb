// The server's configuration: a YAML file of sections with settings, every one of which has a
// default. `isthmus-server --print-config` shows them all.
#pragma once

#include <absl/status/statusor.h>

#include <map>
#include <string>
#include <vector>

#include "server/metrics/metrics_options.h"
#include "server/pipeline_options.h"
#include "server/rpc/server.h"
#include "server/web/web_options.h"
#include "storage/sqlite/sqlite_store.h"

namespace isthmus::server {

struct ServerConfig {
  rpc::ServerOptions rpc;
  metrics::MetricsOptions metrics;
  web::WebOptions web;  // But for `tls`, which are those of `rpc`.
  PipelineOptions pipeline;
  // The URL of a PostgreSQL database that holds the map; empty: the data folder does, by SQLite.
  std::string store = {};
  std::string bucket = {};         // With a database: URL of a bucket for large values, or empty.
  storage::SqliteOptions storage;  // For either kind of store.
  bool standby = false;            // With a database: waits for a site that another server has.
  bool replica = false;            // With a database: only reads the map; another server has it.
  double lease_s = 10;             // See storage::LeaseOptions.
  int cache_mb = 512;              // MiB; see SetCache. Shared by all sites.
  // Maps beside that of the default site, by name; each with settings of its own where the file
  // gives it some.
  std::map<std::string, PipelineOptions> sites = {};
  // For people: settings of earlier versions that the file names, and that are left out.
  std::vector<std::string> warnings = {};
  // The places of the settings that the file names, as "FILE, line 3", by "section.key".
  std::map<std::string, std::string> places = {};
};

// Reads settings from YAML text into defaults. InvalidArgument, with section, key and line, for
// text that is not YAML or has several documents, an unknown section or key, one given twice, a
// value of the wrong type or out of range, and a site's name that cannot be a folder's. A key that
// was a setting once is no error, but a warning.
absl::StatusOr<ServerConfig> ParseConfig(const std::string& yaml);

// As ParseConfig, from a file; its path is in every message and warning. NotFound when it cannot be
// read.
absl::StatusOr<ServerConfig> LoadConfig(const std::string& path);

// An error found later of a setting that the file names, with its place; others as they are.
absl::Status AtPlace(const ServerConfig& config, const std::string& setting,
                     const absl::Status& status);

// Every value as YAML, each with a comment; ParseConfig reads it back to the same.
std::string PrintConfig(const ServerConfig& config);

}  // namespace isthmus::server
