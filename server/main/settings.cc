#include "server/main/settings.h"

#include <absl/strings/ascii.h>
#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>

#include <algorithm>
#include <charconv>
#include <functional>
#include <set>
#include <type_traits>
#include <utility>

#include "server/main/robot_limits.h"

namespace isthmus::server {
namespace {

// The shortest text that reads back to the same number.
template <typename Number>
std::string NumberText(Number number) {
  char text[64];
  const auto end = std::to_chars(text, text + sizeof(text), number).ptr;
  return std::string(text, end);
}

template <typename Number>
bool ParseNumber(const std::string& text, Number* number) {
  if constexpr (std::is_floating_point_v<Number>) {
    return absl::SimpleAtod(text, number);
  } else {
    return absl::SimpleAtoi(text, number);
  }
}

// As YAML in double quotes. Other characters stand as their code: a line's end would be read back
// as a space.
std::string Quoted(const std::string& text) {
  constexpr unsigned char kSpace = ' ', kDelete = 0x7f;
  std::string quoted = "\"";
  for (const char c : text) {
    const auto code = static_cast<unsigned char>(c);
    if (code < kSpace || code == kDelete) {
      absl::StrAppend(&quoted, "\\x", absl::Hex(code, absl::kZeroPad2));
      continue;
    }
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c;
  }
  return quoted + "\"";
}

template <typename Enum>
using Names = std::vector<std::pair<std::string, Enum>>;

class Table {
 public:
  // Settings added from now on belong to this section.
  void Section(std::string name) { section_ = std::move(name); }

  template <typename Number>
  void Add(const char* key, Number* value, Number min, Number max, const char* comment) {
    const auto read = [=](const std::string& text) {
      Number number{};
      // Written so that NaN fails too.
      if (!ParseNumber(text, &number) || !(number >= min && number <= max)) {
        return absl::InvalidArgumentError(
            absl::StrCat("give a number from ", NumberText(min), " to ", NumberText(max)));
      }
      *value = number;
      return absl::OkStatus();
    };
    settings_.push_back({section_, key, comment, read, [value] { return NumberText(*value); }});
  }

  // 0, for none, or in that range: just above 0 a limit would let nothing through.
  void AddOrNone(const char* key, double* value, double min, double max, const char* comment) {
    const auto read = [=](const std::string& text) {
      double number = 0;
      if (!ParseNumber(text, &number) || !(number == 0 || (number >= min && number <= max))) {
        return absl::InvalidArgumentError(
            absl::StrCat("give 0, or a number from ", NumberText(min), " to ", NumberText(max)));
      }
      *value = number;
      return absl::OkStatus();
    };
    settings_.push_back({section_, key, comment, read, [value] { return NumberText(*value); }});
  }

  void Add(const char* key, bool* value, const char* comment) {
    AddChoice(key, value, Names<bool>{{"true", true}, {"false", false}}, comment);
  }

  void Add(const char* key, std::string* value, const char* comment) {
    const auto read = [value](const std::string& text) {
      if (text.empty()) return absl::InvalidArgumentError("give a text that is not empty");
      *value = text;
      return absl::OkStatus();
    };
    settings_.push_back({section_, key, comment, read, [value] { return Quoted(*value); }});
  }

  // A text as it is, such as a file's path or a URL; "" for none.
  void AddFile(const char* key, std::string* value, const char* comment) {
    const auto read = [value](const std::string& text) {
      *value = text;
      return absl::OkStatus();
    };
    AddText(
        key, read, [value] { return *value; }, comment);
  }

  // A value that is its own text; "" too.
  void AddText(const char* key, std::function<absl::Status(const std::string&)> read,
               const std::function<std::string()>& write, const char* comment) {
    settings_.push_back(
        {section_, key, comment, std::move(read), [write] { return Quoted(write()); }});
  }

  template <typename Value>
  void AddChoice(const char* key, Value* value, const Names<Value>& names, const char* comment) {
    const auto read = [value, names](const std::string& text) {
      std::vector<std::string> known;
      for (const auto& [name, choice] : names) {
        known.push_back(name);
        if (name != text) continue;
        *value = choice;
        return absl::OkStatus();
      }
      return absl::InvalidArgumentError(absl::StrCat("give one of ", absl::StrJoin(known, ", ")));
    };
    const auto write = [value, names] {
      for (const auto& [name, choice] : names) {
        if (choice == *value) return name;
      }
      return std::string("?");
    };
    settings_.push_back({section_, key, comment, read, write});
  }

  std::vector<Setting> Take() { return std::move(settings_); }

 private:
  std::string section_;
  std::vector<Setting> settings_;
};

// Limits of one caller and of all. Beyond them: RESOURCE_EXHAUSTED, and when to come again.
void AddCallLimits(rpc::ServerOptions& rpc, Table& table) {
  constexpr size_t kMany = 1'000'000;
  table.Add("max_streams", &rpc.calls.streams, size_t{1}, kMany,
            "Most streams of scans, uploads and localised robots at a time.");
  table.Add("max_streams_per_caller", &rpc.calls.streams_per_caller, size_t{1}, kMany,
            "The same for one caller: all robots of one address together.");
  table.Add("max_queries", &rpc.calls.queries, size_t{1}, kMany,
            "Queries of regions at a time, and of lists; a quarter as many exports. One caller has "
            "half of each at most.");
  table.Add("all_streams_bytes", &rpc.streams.all_bytes, size_t{1} << 23, size_t{1} << 40,
            "Scans of all streams without a written acknowledgement, bytes: beyond it they wait "
            "for each other in turn. One stream has an eighth; all connections together have 256 "
            "MiB more for what is on its way.");
  table.Add("max_connections", &rpc.max_connections, 16, 1'000'000,
            "Most open connections of clients; further ones are closed at once. Not those of "
            "metrics and web, nor of a listener that is a file (unix:).");
}

void AddNetwork(ServerConfig& config, Table& table) {
  table.Section("network");
  rpc::ServerOptions& rpc = config.rpc;
  table.Add("listen", &rpc.listen,
            "host:port, or unix:path; port 0 takes a free one. Other machines reach 0.0.0.0:50051, "
            "which needs TLS or insecure.");
  table.AddFile("tls_certificate", &rpc.tls.certificate,
                "PEM file of the server's certificate, read again when it changes; \"\": no TLS.");
  table.AddFile("tls_key", &rpc.tls.key, "PEM file of its private key, without a passphrase.");
  table.AddFile("tls_client_ca", &rpc.tls.client_ca,
                "PEM file of the authority that signs robots' certificates; every client must then "
                "show one. \"\": none are required.");
  table.Add("insecure", &rpc.insecure,
            "Serve other machines in plain text; only for a network that is safe itself.");
  table.AddChoice("require_token", &rpc.require_token,
                  Names<access::RequireToken>{{"auto", access::RequireToken::kAuto},
                                              {"always", access::RequireToken::kAlways},
                                              {"never", access::RequireToken::kNever}},
                  "Whether each call needs a token. auto: as soon as a token exists. always: even "
                  "before. never: a proxy in front of the server checks callers.");
  table.Add("max_receive_bytes", &rpc.max_receive_bytes, 1 << 16, 1 << 30,
            "Largest message, bytes: the limit of one scan.");
  table.Add("max_submap_bytes", &rpc.max_submap_bytes, uint64_t{1} << 16, uint64_t{1} << 32,
            "Largest submap upload, bytes on the wire.");
  AddCallLimits(rpc, table);
}

void AddMetrics(ServerConfig& config, Table& table) {
  table.Section("metrics");
  metrics::MetricsOptions& metrics = config.metrics;
  const auto read = [&metrics](const std::string& text) {
    metrics.listen = text;
    return absl::OkStatus();
  };
  table.AddText(
      "listen", read, [&metrics] { return metrics.listen; },
      "host:port of http://HOST:PORT/metrics for Prometheus, for example 127.0.0.1:9464; port 0 "
      "takes a free one; \"\": no metrics.");
  table.Add("insecure", &metrics.insecure,
            "Let other machines read the metrics, in plain text and without a token; only for a "
            "network that is safe itself.");
  table.Add("robots", &metrics.robots, 0, 10'000,
            "Most robots of a site with their own numbers, the first since the start; all others "
            "are counted together, as (others).");
}

void AddWeb(ServerConfig& config, Table& table) {
  table.Section("web");
  table.AddFile("listen", &config.web.listen,
                "host:port of the viewer and of the API over HTTP; port 0 takes a free one. With "
                "network.tls_certificate by https. \"\": off.");
  table.Add("insecure", &config.web.insecure,
            "Serve other machines in plain text, which shows tokens to everybody who listens on "
            "the network.");
  const auto read_hosts = [hosts = &config.web.hosts](const std::string& text) {
    const bool is_good = std::ranges::all_of(
        text, [](char c) { return absl::ascii_isprint(static_cast<unsigned char>(c)); });
    if (!is_good) {
      return absl::InvalidArgumentError("give names in ASCII, as browsers send them (xn--...)");
    }
    *hosts = text;
    return absl::OkStatus();
  };
  table.AddText(
      "hosts", read_hosts, [hosts = &config.web.hosts] { return *hosts; },
      "Host names, separated by spaces, of a proxy in front of a server without TLS. Requests for "
      "other names are refused, except addresses, localhost and the machine's own name.");
}

void AddStorage(ServerConfig& config, Table& table) {
  table.Section("storage");
  table.AddFile(
      "store", &config.store,
      "postgresql://USER@HOST/DATABASE: database of the map, with a schema for each site; put the "
      "password into ~/.pgpass or PGPASSWORD. \"\": the map is in the data folder, in SQLite.");
  table.AddFile("bucket", &config.bucket,
                "https://HOST/BUCKET/PREFIX?region=REGION of an S3-compatible object store for the "
                "large values of a map in a database (points, prepared submaps, checkpoints), "
                "which keeps the database's log small. The environment gives AWS_ACCESS_KEY_ID and "
                "AWS_SECRET_ACCESS_KEY. \"\": the map's present bucket, or none.");
  table.Add("standby", &config.standby,
            "With a database: while another server owns the map, wait instead of ending, and take "
            "over once that one is gone. Set it on all servers of a map with spares.");
  table.Add("replica", &config.replica,
            "With a database: only read the map, which another server owns and changes, and answer "
            "readers. Not with standby.");
  table.Add("lease_s", &config.lease_s, 1.0, 3600.0,
            "Seconds without a sign of life in the database after which a server may lose its map "
            "to one that stands by.");
  table.Add("sync_every_commit", &config.storage.sync_every_commit,
            "Wait for the disk on every commit. false: a power cut may lose the last commits.");
  table.Add("resolution_m", &config.storage.resolution_m, 1e-5, 0.1,
            "Step to which stored coordinates are rounded, metres.");
  table.Add("cache_mb", &config.cache_mb, 16, 1'000'000,
            "Memory for points of the map, MiB, for a map of any size: three eighths for submaps, "
            "two for prepared submaps, three for the merged map. Other points are read from the "
            "disk; those of the merged map are in an unnamed file in the data folder.");
}

void AddArchive(ServerConfig& config, Table& table) {
  table.Section("archive");
  ArchiveOptions& archive = config.pipeline.archive;
  table.AddChoice("mode", &archive.mode,
                  Names<ArchiveMode>{{"off", ArchiveMode::kOff},
                                     {"rounded", ArchiveMode::kRounded},
                                     {"full", ArchiveMode::kFull}},
                  "Archive raw scans for isthmus rebuild: off, rounded (coordinates to "
                  "resolution_m) or full (bit by bit).");
  table.Add("required", &archive.required,
            "Refuse a scan that cannot be archived. false: the session continues, and its status "
            "tells which scans are missing.");
  table.Add("resolution_m", &archive.resolution_m, 1e-5, 0.1,
            "Step to which rounded archives round coordinates, metres.");
  table.Add("segment_bytes", &archive.segment_bytes, uint64_t{1} << 16, uint64_t{1} << 40,
            "Size of the archive's files; space is freed file by file.");
}

void AddRetention(ServerConfig& config, Table& table) {
  table.Section("retention");
  RetentionOptions& retention = config.pipeline.retention;
  table.Add("quota_bytes", &retention.limits.quota_bytes, uint64_t{0}, uint64_t{1} << 60,
            "Most bytes stored per robot: submaps, features and raw scans of all its sessions. 0: "
            "no limit.");
  table.Add("total_quota_bytes", &retention.total_quota_bytes, uint64_t{0}, uint64_t{1} << 62,
            "The same for all robots together. 0: no limit.");
  table.AddChoice(
      "over_quota", &retention.over_quota,
      Names<OverQuota>{{"refuse", OverQuota::kRefuse}, {"drop_oldest", OverQuota::kDropOldest}},
      "refuse: a robot above its quota is refused. drop_oldest: raw scans of its finished sessions "
      "are deleted first, then these sessions, the oldest first; then it is refused.");
  table.AddOrNone("max_age_days", &retention.limits.max_age_days, kLeastAgeDays, kMostAgeDays,
                  "Finished sessions older than this are deleted. 0: never.");
  const auto read = [&retention](const std::string& text) -> absl::Status {
    auto robots = ParseRobotLimits(text);
    if (!robots.ok()) return robots.status();
    retention.robots = *std::move(robots);
    return absl::OkStatus();
  };
  table.AddText(
      "robots", read, [&retention] { return PrintRobotLimits(retention.robots); },
      "Limits of single robots instead of these: NAME=QUOTA_BYTES:MAX_AGE_DAYS, separated by "
      "spaces.");
}

void AddIngest(ServerConfig& config, Table& table) {
  table.Section("ingest");
  table.Add("scan_queue", &config.pipeline.scan_queue, size_t{1}, size_t{1024},
            "Most waiting scans of one session; beyond it the robot is slowed down.");
  table.Add("all_queues_bytes", &config.pipeline.all_queues_bytes, size_t{1} << 20, size_t{1} << 40,
            "Bytes of the scans of all sessions that wait, of one an eighth; where they are used "
            "up sessions with scans of up to 1 MiB may still have one waiting.");
  table.Add("max_scan_points", &config.pipeline.max_scan_points, uint64_t{1000},
            uint64_t{4'000'000}, "Scans with more points than this are rejected without decoding.");
  table.AddOrNone(
      "max_scan_rate_hz", &config.pipeline.max_scan_rate_hz, 0.01, 10'000.0,
      "Most scans per second of one session, from 0.01: beyond it a robot is slowed down, or has "
      "scans skipped if it keeps the newest. Recordings are pushed no faster either. 0: no limit.");
  table.Add("max_open_sessions_per_robot", &config.pipeline.max_open_sessions_per_robot, size_t{1},
            size_t{1'000'000}, "Most open sessions of a robot.");
  table.Add("max_open_sessions", &config.pipeline.max_open_sessions, size_t{1}, size_t{1'000'000},
            "The same for all robots together.");
  table.Add("threads", &config.pipeline.ingest_threads, 0, 256,
            "Threads that run odometry; one session uses one at a time. 0: two for each core, at "
            "least 4.");
}

void AddOdometry(ServerConfig& config, Table& table) {
  table.Section("odometry");
  floam::OdometryOptions& odometry = config.pipeline.odometry;
  table.AddChoice("mode", &odometry.mode,
                  Names<OdometryMode>{{"floam", OdometryMode::kFloam},
                                      {"continuous", OdometryMode::kContinuous}},
                  "floam: the paper's two stages of de-skewing. continuous: estimates pose and "
                  "motion within the scan together.");
  table.Add("max_surprise_m", &odometry.max_surprise_m, 0.01, 100.0,
            "Greatest distance of a pose from its prediction; beyond it the scan is lost.");
  table.Add("max_surprise_rad", &odometry.max_surprise_rad, 0.01, 3.2,
            "The same for the rotation.");
}

void AddSubmaps(ServerConfig& config, Table& table) {
  table.Section("submaps");
  floam::SubmapOptions& submap = config.pipeline.submap;
  table.Add("keyframe_voxel_m", &submap.keyframe_voxel_m, 0.01, 10.0,
            "A keyframe has one point per voxel of this edge.");
  table.Add("max_range_m", &submap.max_range_m, 1.0, 1000.0,
            "Farther points are dropped: they are too sparse for matching.");
  table.Add("cut_distance_m", &submap.cut_distance_m, 0.1, 10'000.0,
            "A submap ends, and becomes durable, after this much travel ...");
  table.Add("cut_scans", &submap.cut_scans, 1, 60'000, "... or this many scans.");
}

void AddMatching(ServerConfig& config, Table& table) {
  table.Section("matching");
  matching::MatcherOptions& matcher = config.pipeline.matcher;
  table.AddChoice("search", &matcher.search,
                  Names<matching::SearchMode>{{"default", matching::SearchMode::kDefault},
                                              {"paper", matching::SearchMode::kPaper},
                                              {"birds_eye", matching::SearchMode::kBirdsEye}},
                  "The searches that propose transforms. paper: key points and features. "
                  "birds_eye: exhaustive search of the plan view. default: birds_eye and places "
                  "that look alike, and paper if these find nothing likely indoors.");
  table.Add("rematch_submaps", &config.pipeline.rematch_submaps, 1, 1000,
            "A pair is matched again when its maps have grown by this many submaps. The cost is "
            "mostly that of the new submaps.");
}

// The checks a match has to pass, in the order of docs/concepts.md.
void AddAcceptance(ServerConfig& config, Table& table) {
  matching::MatcherOptions& matcher = config.pipeline.matcher;
  table.Add("min_probability", &matcher.min_probability, 0.5, 0.9999,
            "Least probability of an accepted match. A wrong merge destroys a map, a missed one "
            "only waits: higher is safer.");
  table.AddChoice(
      "twins", &matcher.twins,
      Names<matching::Twins>{{"rare", matching::Twins::kRare},
                             {"possible", matching::Twins::kPossible},
                             {"exact", matching::Twins::kExact}},
      "How often whole places of the site are built and furnished alike. rare: hardly ever. "
      "possible: closed places of up to 400 m2 wait until a robot sees more or anchors decide; "
      "larger places wait less often, from 1000 m2 on never. exact, for hotels and rack halls: a "
      "pair waits if a closed place is most of what a robot saw.");
  table.Add("min_observability", &matcher.min_observability, 0.0, 1.0,
            "Least observability of a match along its weakest direction; a looser match, for "
            "example along a bare corridor, waits.");
  table.Add("max_odometry_residual", &matcher.max_odometry_residual, 0.01, 1000.0,
            "Greatest bending of the odometry that makes the maps fit, in standard deviations "
            "(RMS); with more a match waits.");
}

// The drift of odometry: the range within which loop closures are looked for, and how far they bend
// it.
void AddPlacement(ServerConfig& config, Table& table) {
  table.Section("placement");
  table.Add("drift_per_m", &config.pipeline.placer.drift.position_per_m, 1e-5, 1.0,
            "Drift of odometry per metre travelled, one standard deviation: 0.005 is 0.5 %.");
  table.Add("loops", &config.pipeline.loops.enabled,
            "Close loops: search for places to which a robot comes back, to correct its drift.");
}

void AddRevisits(ServerConfig& config, Table& table) {
  table.Section("revisits");
  matching::RevisitOptions& revisits = config.pipeline.revisits;
  table.Add("retire", &revisits.retire,
            "Retire submaps, with the poses of their scans, once they were seen again often "
            "enough. false: all submaps stay, and the map grows with every lap.");
  table.Add(
      "min_looks", &revisits.min_looks, 2, 1000,
      "By how many newer submaps 90 % of its surface was seen again, or seen through because it "
      "is gone: more keep more of the past.");
}

void AddComposition(ServerConfig& config, Table& table) {
  table.Section("composition");
  table.Add("interval_s", &config.pipeline.composition_interval_s, 0.0, 3600.0,
            "Longest rest between two compositions of the merged map; 0: none.");
  composition::ComposerOptions& composer = config.pipeline.composer;
  table.Add("tile_m", &composer.tile_m, 1.0, 1000.0,
            "Edge of the tiles that are remade when a submap in them moves.");
  table.Add("voxel_m", &composer.voxel_m, 0.01, 10.0,
            "The merged map has one point per voxel of this edge and robot.");
  table.Add("drop_gone", &composer.drop_gone,
            "Drop points that later rays went through: people, cars, things taken away. `isthmus "
            "export --dynamic` writes them.");
  composition::OccupancyOptions& occupancy = config.pipeline.occupancy;
  table.Add("octomap_max_range_m", &occupancy.max_range_m, 1.0, 1000.0,
            "Greatest length of rays in an OctoMap.");
  table.Add("octomap_cache_mb", &config.pipeline.octomap_cache_mb, 0, 1'000'000,
            "Memory for the evidence of rays, MiB, kept between OctoMaps so that only changed "
            "parts are cast again; 0: cast all every time.");
}

}  // namespace

std::vector<Setting> SettingsOf(ServerConfig& config) {
  Table table;
  AddNetwork(config, table);
  AddMetrics(config, table);
  AddWeb(config, table);
  AddStorage(config, table);
  AddArchive(config, table);
  AddRetention(config, table);
  AddIngest(config, table);
  AddOdometry(config, table);
  AddSubmaps(config, table);
  AddMatching(config, table);
  AddAcceptance(config, table);
  AddPlacement(config, table);
  AddRevisits(config, table);
  AddComposition(config, table);
  return table.Take();
}

bool WasSetting(const std::string& name) {
  static const auto* const kFormer = new std::set<std::string>{
      "composition.max_tiles",
      "composition.min_move_m",
      "composition.octomap_hit",
      "composition.octomap_least",
      "composition.octomap_miss",
      "composition.octomap_most",
      "composition.octomap_resolution_m",
      "ingest.scan_queue_bytes",
      "matching.max_enclosed_share",
      "matching.min_enclosed_area_m2",
      "network.connection_bytes",
      "network.first_message_ms",
      "network.max_calls_per_connection",
      "network.max_exports",
      "network.max_lists",
      "network.max_threads",
      "network.progress_ms",
      "network.scan_window",
      "network.stream_bytes",
      "odometry.map_angle_rad",
      "odometry.map_distance_m",
      "odometry.map_max_blocks",
      "odometry.map_radius_m",
      "odometry.max_scan_work",
      "placement.drift_rad_per_m",
      "placement.drift_rad_per_rad",
      "revisits.grace_h",
      "revisits.keep_newest",
      "revisits.min_share",
      "submaps.keyframe_angle_rad",
      "submaps.keyframe_distance_m",
      "submaps.keyframe_interval_s",
  };
  return kFormer->contains(name);
}

}  // namespace isthmus::server
