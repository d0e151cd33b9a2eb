// isthmus-server: takes robots' scans, keeps and joins their maps, answers readers.
#include <absl/cleanup/cleanup.h>
#include <absl/strings/str_cat.h>
#include <signal.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/address.h"
#include "core/site_name.h"
#include "server/access/tokens.h"
#include "server/main/config.h"
#include "server/main/data_folder.h"
#include "server/main/database_maps.h"
#include "server/main/failed_call_log.h"
#include "server/main/log.h"
#include "server/main/open_files.h"
#include "server/main/open_map.h"
#include "server/main/program.h"
#include "server/main/server_events.h"
#include "server/main/standby.h"
#include "server/main/stop_signal.h"
#include "server/main/supervision.h"
#include "server/metrics/metrics.h"
#include "server/pipeline.h"
#include "server/rpc/server.h"
#include "server/rpc/tls.h"
#include "server/web/web_server.h"
#include "storage/upkeep/backup_stream.h"
#include "storage/upkeep/check_store.h"

namespace isthmus::server {
namespace {

// A source of backups of the folder that this process has open, unless the map is elsewhere.
rpc::BackupSource BackupsOf(const std::string& folder, bool is_elsewhere) {
  if (is_elsewhere) {
    return [](const rpc::BackupSink&) {
      return absl::FailedPreconditionError(
          "the map is in a PostgreSQL database: back that up with pg_dump --schema (one site) or "
          "pg_basebackup (the whole server); isthmus copy makes a map folder from it");
    };
  }
  return [folder](const rpc::BackupSink& sink) -> absl::StatusOr<BackupContents> {
    const absl::StatusOr<storage::StoreReport> report =
        storage::StreamBackup(folder, {sink.progress, sink.begin, sink.piece});
    if (!report.ok()) return report.status();
    return BackupContents{report->sessions, report->submaps,       report->scans,
                          report->points,   report->damaged_count, ToString(*report)};
  };
}

// Exit codes beside kUsage, as docs/api.md promises them.
enum ExitCode { kStopped = 0, kDataFolder = 3, kCannotListen = 4, kTakenOver = 5 };

// Calls under way have this long to end before they are cancelled.
constexpr std::chrono::seconds kGrace{1};

struct Arguments {
  std::string data;
  std::string listen;
  std::string web;
  std::string store;
  std::string config_path;
  bool insecure = false;
  bool standby = false;
  bool replica = false;
  LogOptions log;
  bool print_config = false;
  bool check = false;
};

// The code to exit with where the program is to end here.
std::optional<int> Parse(int argc, char** argv, Arguments& arguments) {
  CLI::App app("Accepts robots' scans, stores and joins their maps, and answers readers.",
               "isthmus-server");
  app.set_version_flag("--version", "isthmus-server " ISTHMUS_VERSION);
  app.add_option("--data", arguments.data, "Folder of the map; created if missing");
  app.add_option("--listen", arguments.listen,
                 "host:port to listen at, port 0 for a free one (default 127.0.0.1:50051)");
  app.add_option("--web", arguments.web,
                 "host:port of the viewer and of the API over HTTP (default: off); web.listen");
  app.add_option(
      "--store", arguments.store,
      "PostgreSQL database of the map, postgresql://USER@HOST/DATABASE (default: SQLite, "
      "in the folder)");
  app.add_flag(
      "--standby", arguments.standby,
      "Wait while another server owns the database's map, and take over once that one is gone");
  app.add_flag("--replica", arguments.replica,
               "Only read the database's map, which another server owns, and answer readers");
  app.add_flag("--insecure", arguments.insecure,
               "Serve other machines in plain text; only for a network that is safe itself");
  app.add_option("--config", arguments.config_path, "YAML file of settings; see --print-config");
  app.add_flag("--print-config", arguments.print_config, "Print every effective setting and exit");
  std::string check_folder;
  const CLI::Option* check =
      app.add_option(
             "--check", check_folder,
             "Read the whole map in DIR (or --data DIR), list damaged records, and exit: 0 sound, "
             "1 damaged, 2 cannot be read. Changes nothing; refused while a server uses the map")
          ->expected(0, 1)
          ->type_name("[DIR]");
  AddLogOptions(app, arguments.log);
  return ParseArguments(app, argc, argv, [&] {
    arguments.check = check->count() > 0;
    if (arguments.check && !arguments.store.empty()) throw CLI::ExcludesError("--check", "--store");
    if (!check_folder.empty()) {
      if (!arguments.data.empty()) throw CLI::ExcludesError("--check DIR", "--data");
      arguments.data = check_folder;
    }
    if (arguments.data.empty() && (arguments.check || !arguments.print_config)) {
      throw CLI::RequiredError("--data DIR, the folder of the map,");
    }
  });
}

// Most failed calls are the client's affair, some the server's.
bool IsOurs(const absl::Status& status) {
  return absl::IsResourceExhausted(status) || absl::IsInternal(status) ||
         absl::IsDataLoss(status) || absl::IsUnknown(status);
}

rpc::OnFailedCall LogFailedCalls() {
  auto log =
      std::make_shared<FailedCallLog>([](const rpc::FailedCall& call, const std::string& line) {
        Log(IsOurs(call.status) ? spdlog::level::warn : spdlog::level::info, line, FieldsOf(call));
      });
  return [log](const rpc::FailedCall& call) { log->Note(call); };
}

// Connections need files.
void TakeOpenFiles() {
  constexpr uint64_t kFew = 4096;
  const uint64_t files = RaiseOpenFiles();
  if (files >= kFew) return;
  spdlog::warn(
      "this process may open only {} files and refuses further connections: raise the hard limit "
      "(LimitNOFILE= of systemd, ulimit -Hn)",
      files);
}

// True if everything that was acknowledged is stored; says so.
bool ReportStop(const std::vector<OpenMap>& maps) {
  bool stored = true;
  for (const OpenMap& map : maps) {
    for (const SessionStatus& session : map.pipeline->sessions().List()) {
      if (session.durable_sequence >= session.last_sequence) continue;
      stored = false;
      LogFields fields;
      fields.site = map.name;
      fields.robot = session.record.robot.value();
      fields.session = session.record.id.value();
      fields.sequence = session.durable_sequence + 1;
      Log(spdlog::level::err,
          absl::StrCat(session.record.id.value(), ": scans ", session.durable_sequence + 1, " to ",
                       session.last_sequence,
                       " could not be stored; the robot must send them again"),
          fields);
    }
  }
  if (stored) spdlog::info("everything that was acknowledged is stored");
  return stored;
}

// Everything is up; returns after a signal.
ExitCode ServeUntilSignal(rpc::RpcServer& server, std::unique_ptr<web::WebServer> web,
                          const std::vector<OpenMap>& maps, const ServerConfig& config,
                          StopSignal& signal) {
  std::printf("isthmus-server listening on %s\n", server.address().c_str());
  std::fflush(stdout);
  Supervision supervision(config, server.address(), [&maps](const std::string& trouble) {
    LogToAllSites(maps, EventKind::kCertificateExpires, trouble);
  });
  const std::string name = signal.Wait(OnHangup);
  spdlog::info("{} received: storing acknowledged data; a second signal stops at once", name);
  supervision.Stop();
  web.reset();  // Its calls go through the server.
  // Calls may wait for room in a queue: scans that are still in it by then are let go of.
  std::promise<void> ended;
  std::thread hurry([&maps, done = ended.get_future()] {
    if (done.wait_for(kGrace) != std::future_status::timeout) return;
    for (const OpenMap& map : maps) map.pipeline->StopTaking();
  });
  server.Shutdown(kGrace);
  ended.set_value();
  hurry.join();
  LogToAllSites(maps, EventKind::kServerStopped, absl::StrCat("server stopped by ", name));
  for (const OpenMap& map : maps) map.pipeline->Shutdown();
  if (!ReportStop(maps)) return kDataFolder;
  return kStopped;
}

void SayWhoIsLetIn(const rpc::ServerOptions& options, bool any) {
  const access::RequireToken require = options.require_token;
  if (!any && require == access::RequireToken::kAuto && IsThisMachine(options.listen)) {
    spdlog::info("there is no token yet: everybody on this machine may do everything");
  } else if (require == access::RequireToken::kNever) {
    spdlog::warn("no token is required (network.require_token: never)");
  } else if (!any && require == access::RequireToken::kAuto) {
    spdlog::warn(
        "there is no token yet: everybody who reaches this server may do everything. `isthmus "
        "token create` makes the first one, and from then on each call needs one");
  } else if (!any) {
    spdlog::warn(
        "there is no token yet, so every caller is refused: `isthmus token create --data`");
  }
}

int Check(const std::string& folder) {
  enum { kSound = 0, kDamaged = 1, kUnreadable = 2 };
  absl::Status status = CheckMapIsHere(folder);
  absl::StatusOr<storage::StoreReport> report;
  if (status.ok()) {
    report = storage::CheckStore(folder);
    status = report.status();
  }
  if (!status.ok()) {
    spdlog::error("{}", std::string(status.message()));
    return kUnreadable;
  }
  std::printf("%s", storage::ToString(*report).c_str());
  return report->damaged_count == 0 ? kSound : kDamaged;
}

// Checks the settings of the network that a person has to put right before a start.
absl::Status CheckNetwork(const ServerConfig& config) {
  absl::Status status = CheckAddress(config.rpc.listen, PortZero::kAnyFreeOne);
  if (status.ok()) status = rpc::CheckListening(config.rpc);
  if (!status.ok()) return AtPlace(config, "network.listen", status);
  status = rpc::OpenKeys(config.rpc.tls).status();
  if (!status.ok()) return AtPlace(config, "network.tls_certificate", status);
  status = AtPlace(config, "metrics.listen", metrics::CheckListening(config.metrics));
  if (!status.ok()) return status;
  return AtPlace(config, "web.listen", web::CheckListening(config.web));
}

// Checks how the map in a database is shared.
absl::Status CheckStore(const ServerConfig& config) {
  if (config.standby && config.replica) {
    return absl::InvalidArgumentError(
        "--standby (storage.standby) and --replica (storage.replica) exclude each other: a server "
        "either waits for the map or reads it");
  }
  if (config.store.empty() && !config.bucket.empty()) {
    return AtPlace(config, "storage.bucket",
                   absl::InvalidArgumentError(
                       "storage.bucket needs a map in a database: give that with --store"));
  }
  if (!config.store.empty() || (!config.standby && !config.replica)) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(
      config.standby ? "--standby (storage.standby)" : "--replica (storage.replica)",
      " needs a map in a database that several servers reach: give that with --store"));
}

// Counter of all work for the metrics; null: there are none. Sites and the network tell it.
std::unique_ptr<metrics::Metrics> CountFor(ServerConfig* config) {
  if (config->metrics.listen.empty()) return nullptr;
  auto counting = std::make_unique<metrics::Metrics>(config->metrics, ISTHMUS_VERSION);
  config->pipeline.observer = counting->ObserverOf(kDefaultSite);
  for (auto& [name, options] : config->sites) options.observer = counting->ObserverOf(name);
  config->rpc.on_ended_call = [counting = counting.get()](const std::string& rpc,
                                                          absl::StatusCode code, double seconds) {
    counting->NoteCall(rpc, code, seconds);
  };
  return counting;
}

absl::Status ServeMetrics(const std::vector<OpenMap>& maps, metrics::Metrics* counting) {
  if (counting == nullptr) return absl::OkStatus();
  std::vector<metrics::MeasuredSite> sites;
  sites.reserve(maps.size());
  for (const OpenMap& map : maps) sites.push_back({map.name, map.pipeline.get()});
  if (absl::Status status = counting->Serve(sites); !status.ok()) return status;
  spdlog::info("metrics at http://{}/metrics", counting->address());
  return absl::OkStatus();
}

// Null: nothing is served to browsers.
absl::StatusOr<std::unique_ptr<web::WebServer>> ServeWeb(const web::WebOptions& options,
                                                         rpc::RpcServer& server) {
  if (options.listen.empty()) return nullptr;
  auto web = web::WebServer::Start(options, server);
  if (!web.ok()) return web.status();
  spdlog::info("web at {}", (*web)->url());
  server.TellWebAddress((*web)->url());
  return web;
}

// Waits for them where the configuration says so.
absl::StatusOr<std::vector<OpenMap>> OpenAll(const std::string& folder, const ServerConfig& config,
                                             StopSignal& signal) {
  SiteEvents events;
  events.on_lost = [](const std::string& why) { EndTakenOver(why, kTakenOver); };
  std::unique_ptr<Standby> standby;
  if (config.standby) standby = std::make_unique<Standby>(&signal);
  events.on_wait = [&standby](const std::string& why) { standby->Note(why); };
  return OpenMaps(folder, config, events);
}

int Run(const Arguments& arguments, StopSignal& signal) {
  if (arguments.check) {
    signal.Unblock();
    return Check(arguments.data);
  }
  absl::StatusOr<ServerConfig> config = ServerConfig();
  if (!arguments.config_path.empty()) config = LoadConfig(arguments.config_path);
  if (!config.ok()) return Fail(kUsage, config.status());
  for (const std::string& warning : config->warnings) spdlog::warn("{}", warning);
  const auto take = [&config](const char* name, const std::string& given, std::string* setting) {
    if (given.empty()) return;
    *setting = given;
    config->places.erase(name);
  };
  take("network.listen", arguments.listen, &config->rpc.listen);
  take("web.listen", arguments.web, &config->web.listen);
  take("storage.store", arguments.store, &config->store);
  if (arguments.insecure) config->rpc.insecure = true;
  if (absl::Status status = CheckDatabase(*config); !status.ok()) return Fail(kUsage, status);
  if (arguments.standby) config->standby = true;
  if (arguments.replica) config->replica = true;
  if (arguments.print_config) {
    std::fputs(PrintConfig(*config).c_str(), stdout);
    return kStopped;
  }
  if (absl::Status status = CheckStore(*config); !status.ok()) return Fail(kUsage, status);
  config->web.tls = config->rpc.tls;
  if (absl::Status status = CheckNetwork(*config); !status.ok()) return Fail(kUsage, status);
  // A limit on the size of files is a full disk, which is lived with, not the end.
  ::signal(SIGXFSZ, SIG_IGN);
  TakeOpenFiles();
  if (absl::Status status = MakeDataFolder(arguments.data); !status.ok()) {
    return Fail(kDataFolder, status);
  }
  const auto warn = [](const std::string& problem) { spdlog::warn("{}", problem); };
  auto tokens = access::Tokens::Open(arguments.data, warn);
  if (!tokens.ok()) return Fail(kDataFolder, tokens.status());
  SayWhoIsLetIn(config->rpc, (*tokens)->any());
  config->rpc.tokens = tokens->get();
  config->storage.on_problem = warn;
  const auto counting = CountFor(&*config);  // Outlives the maps, whose work it counts.
  bool has_served = false;
  // Computations, which are done again, end when the maps go: only then has the server stopped.
  const absl::Cleanup say_stopped = [&has_served] {
    if (has_served) spdlog::info("stopped");
  };
  const auto maps = OpenAll(arguments.data, *config, signal);
  if (!maps.ok()) return Fail(kDataFolder, maps.status());
  std::vector<rpc::ServedSite> sites;
  for (const OpenMap& map : *maps) {
    const MapInfo info = map.pipeline->GetMapInfo();
    spdlog::info("{}: revision {}, {} robots", map.folder, info.revision, info.robots.size());
    sites.push_back({map.name, map.pipeline.get(), BackupsOf(map.folder, !config->store.empty()),
                     map.folder + "/uploads"});
  }
  config->rpc.on_failed_call = LogFailedCalls();
  auto server = rpc::RpcServer::Start(sites, config->rpc);
  if (!server.ok()) return Fail(kCannotListen, server.status());
  if (absl::Status status = ServeMetrics(*maps, counting.get()); !status.ok()) {
    return Fail(kCannotListen, status);
  }
  const absl::Cleanup no_more_scrapes = [&] {
    if (counting != nullptr) counting->Stop();
  };
  auto web = ServeWeb(config->web, **server);
  if (!web.ok()) return Fail(kCannotListen, web.status());
  NoteStart(*maps, ISTHMUS_VERSION);
  has_served = true;
  return ServeUntilSignal(**server, *std::move(web), *maps, *config, signal);
}

}  // namespace

}  // namespace isthmus::server

int main(int argc, char** argv) {
  isthmus::server::StopSignal signal;
  isthmus::server::Arguments arguments;
  const std::optional<int> code = isthmus::server::Parse(argc, argv, arguments);
  if (code) return *code;
  setenv("GRPC_VERBOSITY", "NONE", 0);  // Errors that matter come back as a status.
  return isthmus::server::RunProgram("isthmus-server", arguments.log, isthmus::server::kDataFolder,
                                     [&] { return isthmus::server::Run(arguments, signal); });
}
