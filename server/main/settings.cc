#include "server/main/settings.h"

#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>

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
            "Streams of scans, uploads and robots that are localised, at a time.");
  table.Add("max_streams_per_caller", &rpc.calls.streams_per_caller, size_t{1}, kMany,
            "Those of one caller: of one address, all its robots together.");
  table.Add("max_queries", &rpc.calls.queries, size_t{1}, kMany,
            "Queries of regions at a time, and of lists; a quarter as many exports. One caller has "
            "half of each at most.");
  table.Add("all_streams_bytes", &rpc.streams.all_bytes, size_t{1} << 23, size_t{1} << 40,
            "Scans of all streams without a written acknowledgement, bytes: beyond it they wait "
            "for each other in turn. One stream has an eighth; all connections together have 256 "
            "MiB more for what is on its way.");
  table.Add("max_connections", &rpc.max_connections, 16, 1'000'000,
            "Connections that may be open, about (other files of the process count among them). "
            "Further ones are closed at once.");
}

void AddNetwork(ServerConfig& config, Table& table) {
  table.Section("network");
  rpc::ServerOptions& rpc = config.rpc;
  table.Add("listen", &rpc.listen,
            "host:port, or unix:path; port 0 takes a free one. 0.0.0.0:50051 is reached from other "
            "machines: with TLS, or insecure.");
  table.AddFile("tls_certificate", &rpc.tls.certificate,
                "PEM file of the server's certificate, read again when it changes; \"\": no TLS.");
  table.AddFile("tls_key", &rpc.tls.key, "PEM file of its private key, without a passphrase.");
  table.AddFile("tls_client_ca", &rpc.tls.client_ca,
                "PEM file of who signs robots' certificates, which every client must show then; "
                "\"\": none are asked for.");
  table.Add("insecure", &rpc.insecure,
            "Whether other machines may be served in plain text: where the network itself is "
            "safe.");
  table.AddChoice("require_token", &rpc.require_token,
                  Names<access::RequireToken>{{"auto", access::RequireToken::kAuto},
                                              {"always", access::RequireToken::kAlways},
                                              {"never", access::RequireToken::kNever}},
                  "Whether each call needs a token. auto: as soon as there is one. always: also "
                  "before. never: something in front of the server lets callers in.");
  table.Add("max_receive_bytes", &rpc.max_receive_bytes, 1 << 16, 1 << 30,
            "Largest message taken, bytes: the limit of one scan.");
  table.Add("max_submap_bytes", &rpc.max_submap_bytes, uint64_t{1} << 16, uint64_t{1} << 32,
            "Largest submap upload, bytes as they travel.");
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
      "host:port at which Prometheus finds http://HOST:PORT/metrics, as 127.0.0.1:9464; port 0 "
      "takes a free one; \"\": no metrics.");
  table.Add("insecure", &metrics.insecure,
            "Whether other machines may read them, in plain text and without a token: where the "
            "network itself is safe.");
  table.Add("robots", &metrics.robots, 0, 10'000,
            "Robots of a site that have numbers of their own, those that came first since the "
            "start; the rest are counted together, as (others).");
}

void AddWeb(ServerConfig& config, Table& table) {
  table.Section("web");
  table.AddFile("listen", &config.web.listen,
                "host:port at which browsers are served: the viewer, and the API over HTTP; port 0 "
                "takes a free one. With network.tls_certificate by https. \"\": nothing is.");
  table.Add("insecure", &config.web.insecure,
            "Whether an address that other machines reach may be served so in plain text, which "
            "shows tokens to who listens on the way.");
  table.AddFile("hosts", &config.web.hosts,
                "Names, separated by spaces, under which a proxy in front is reached, where there "
                "is one and this server has no TLS. Others are refused, but addresses, localhost "
                "and the machine's own name.");
}

void AddStorage(ServerConfig& config, Table& table) {
  table.Section("storage");
  table.AddFile("store", &config.store,
                "postgresql://USER@HOST/DATABASE: the map is kept in this database, for each site "
                "in a schema of its own; the password belongs into ~/.pgpass or PGPASSWORD. \"\": "
                "it is kept in the data folder, by SQLite.");
  table.AddFile(
      "bucket", &config.bucket,
      "https://HOST/BUCKET/PREFIX?region=REGION of an S3-compatible object store, with a database: "
      "it gets the large values (points of submaps, what matching made of them, checkpoints), "
      "and the database less to log. Credentials are AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY "
      "of the environment. \"\": the bucket that the map has, or none.");
  table.Add("standby", &config.standby,
            "With a database: while another server has the map, wait for it in place of ending, "
            "and take over once that one is gone. For all servers of a map with spares.");
  table.Add("replica", &config.replica,
            "With a database: only read the map, which another server has and changes, and answer "
            "readers. Not with standby.");
  table.Add("lease_s", &config.lease_s, 1.0, 3600.0,
            "A server that has given the database no sign of life for so long, in seconds, may "
            "lose its map to one that stands by.");
  table.Add("sync_every_commit", &config.storage.sync_every_commit,
            "Wait for the disk on every commit. false: a power cut may lose the last ones.");
  table.Add("resolution_m", &config.storage.resolution_m, 1e-5, 0.1,
            "Step to which stored coordinates are rounded, metres.");
  table.Add(
      "cache_mb", &config.cache_mb, 16, 1'000'000,
      "Memory for points of the map, MiB, however large it is: three eighths for submaps, two "
      "for those made ready for matching, three for the merged map. What it has no room for "
      "is read from the disk, that of the merged map from a file without a name in the data "
      "folder.");
}

void AddArchive(ServerConfig& config, Table& table) {
  table.Section("archive");
  ArchiveOptions& archive = config.pipeline.archive;
  table.AddChoice("mode", &archive.mode,
                  Names<ArchiveMode>{{"off", ArchiveMode::kOff},
                                     {"rounded", ArchiveMode::kRounded},
                                     {"full", ArchiveMode::kFull}},
                  "Raw scans are kept, for isthmus rebuild: off, rounded (coordinates to "
                  "resolution_m) or full (bit by bit).");
  table.Add("required", &archive.required,
            "A scan that cannot be kept is refused. false: the session goes on, and its status "
            "says what is missing.");
  table.Add("resolution_m", &archive.resolution_m, 1e-5, 0.1,
            "Of rounded: step to which coordinates are rounded, metres.");
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
            "The same of all robots together. 0: no limit.");
  table.AddChoice(
      "over_quota", &retention.over_quota,
      Names<OverQuota>{{"refuse", OverQuota::kRefuse}, {"drop_oldest", OverQuota::kDropOldest}},
      "A robot above its quota is refused. drop_oldest: raw scans of its finished "
      "sessions go first, then such sessions, the oldest first; then it is refused.");
  table.Add("max_age_days", &retention.limits.max_age_days, 0.0, 36'500.0,
            "Finished sessions are deleted when they are older. 0: never.");
  const auto read = [&retention](const std::string& text) -> absl::Status {
    auto robots = ParseRobotLimits(text);
    if (!robots.ok()) return robots.status();
    retention.robots = *std::move(robots);
    return absl::OkStatus();
  };
  table.AddText(
      "robots", read, [&retention] { return PrintRobotLimits(retention.robots); },
      "Limits of single robots in place of these: NAME=QUOTA_BYTES:MAX_AGE_DAYS, separated by "
      "spaces.");
}

void AddIngest(ServerConfig& config, Table& table) {
  table.Section("ingest");
  table.Add("scan_queue", &config.pipeline.scan_queue, size_t{1}, size_t{1024},
            "Scans of one session that may wait; the robot is slowed down when they are full.");
  table.Add("all_queues_bytes", &config.pipeline.all_queues_bytes, size_t{1} << 20, size_t{1} << 40,
            "Bytes of the scans of all sessions that wait, of one an eighth; where they are used "
            "up sessions with scans of up to 1 MiB may still have one waiting.");
  table.Add("max_scan_points", &config.pipeline.max_scan_points, uint64_t{1000},
            uint64_t{4'000'000}, "Scans of more points are rejected, without being decoded.");
  table.Add(
      "max_scan_rate_hz", &config.pipeline.max_scan_rate_hz, 0.0, 10'000.0,
      "Scans a second of one session: beyond it a robot is slowed down, and one that keeps the "
      "newest has scans skipped. Recordings are pushed no faster either. 0: no limit.");
  table.Add("max_open_sessions_per_robot", &config.pipeline.max_open_sessions_per_robot, size_t{1},
            size_t{1'000'000}, "Sessions of a robot that are not finished; no more are opened.");
  table.Add("max_open_sessions", &config.pipeline.max_open_sessions, size_t{1}, size_t{1'000'000},
            "The same of all robots together.");
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
                  "floam: the paper's two stages of de-skewing. continuous: pose and motion within "
                  "the scan are estimated together.");
  table.Add("max_surprise_m", &odometry.max_surprise_m, 0.01, 100.0,
            "A pose farther than this from its prediction is not believed: the scan is lost.");
  table.Add("max_surprise_rad", &odometry.max_surprise_rad, 0.01, 3.2,
            "The same for its rotation.");
}

void AddSubmaps(ServerConfig& config, Table& table) {
  table.Section("submaps");
  floam::SubmapOptions& submap = config.pipeline.submap;
  table.Add("keyframe_voxel_m", &submap.keyframe_voxel_m, 0.01, 10.0,
            "A keyframe has one point per voxel of this edge.");
  table.Add("max_range_m", &submap.max_range_m, 1.0, 1000.0,
            "Farther points are not kept: too sparse to match on.");
  table.Add("cut_distance_m", &submap.cut_distance_m, 0.1, 10'000.0,
            "A submap ends, and becomes durable, after this much travel ...");
  table.Add("cut_scans", &submap.cut_scans, 1, 60'000, "... or this many scans.");
}

void AddMatching(ServerConfig& config, Table& table) {
  table.Section("matching");
  matching::MatcherOptions& matcher = config.pipeline.matcher;
  table.AddChoice(
      "search", &matcher.search,
      Names<matching::SearchMode>{{"default", matching::SearchMode::kDefault},
                                  {"paper", matching::SearchMode::kPaper},
                                  {"birds_eye", matching::SearchMode::kBirdsEye}},
      "Who proposes transforms. paper: key points and features. birds_eye: exhaustive search of "
      "the plan view. default: birds_eye and places that look alike; paper too where these find "
      "nothing likely indoors.");
  table.Add("rematch_submaps", &config.pipeline.rematch_submaps, 1, 1000,
            "A pair is matched again when its maps have grown by this many submaps. Mostly this "
            "costs as much as is new in them.");
}

// The checks a match has to pass, in the order of docs/concepts.md.
void AddAcceptance(ServerConfig& config, Table& table) {
  matching::MatcherOptions& matcher = config.pipeline.matcher;
  table.Add(
      "min_probability", &matcher.min_probability, 0.5, 0.9999,
      "Probability of being right from which on a match is accepted. A wrong merge destroys a "
      "map, a missed one waits: higher is safer.");
  table.AddChoice("twins", &matcher.twins,
                  Names<matching::Twins>{{"rare", matching::Twins::kRare},
                                         {"possible", matching::Twins::kPossible},
                                         {"exact", matching::Twins::kExact}},
                  "How often whole places of the site are built and furnished alike. rare: hardly "
                  "ever. possible: closed places of up to 400 m2 wait until a robot sees more or "
                  "anchors tell, larger ones the less, from 1000 m2 on none. exact, as in hotels "
                  "and rack halls: wherever a closed place is most of what a robot saw.");
  table.Add("min_observability", &matcher.min_observability, 0.0, 1.0,
            "How firmly a match must be held in the direction in which it could slide best; a "
            "looser one, as along a bare corridor, waits.");
  table.Add("max_odometry_residual", &matcher.max_odometry_residual, 0.01, 1000.0,
            "Standard deviations (RMS) that the odometry may have to bend for the maps to fit; "
            "with more a match waits.");
}

// The drift of odometry: the range within which loop closures are looked for, and how far they bend
// it.
void AddPlacement(ServerConfig& config, Table& table) {
  table.Section("placement");
  table.Add("drift_per_m", &config.pipeline.placer.drift.position_per_m, 1e-5, 1.0,
            "How far odometry strays per metre gone, one standard deviation: 0.005 is 0.5 %.");
  table.Add("loops", &config.pipeline.loops.enabled,
            "Whether places that a robot comes back to are looked for, to correct its drift.");
}

void AddRevisits(ServerConfig& config, Table& table) {
  table.Section("revisits");
  matching::RevisitOptions& revisits = config.pipeline.revisits;
  table.Add("retire", &revisits.retire,
            "Whether submaps leave, with the poses of their scans, once they were seen again often "
            "enough. false: all is kept, and the map grows with every lap.");
  table.Add(
      "min_looks", &revisits.min_looks, 2, 1000,
      "By how many newer submaps 90 % of its surface was seen again, or seen through because it "
      "is gone: more keep more of the past.");
}

void AddComposition(ServerConfig& config, Table& table) {
  table.Section("composition");
  table.Add("interval_s", &config.pipeline.composition_interval_s, 0.0, 3600.0,
            "The longest rest between two compositions of the merged map; 0: none.");
  composition::ComposerOptions& composer = config.pipeline.composer;
  table.Add("tile_m", &composer.tile_m, 1.0, 1000.0,
            "Edge of the tiles that are remade when something in them moved.");
  table.Add("voxel_m", &composer.voxel_m, 0.01, 10.0,
            "The merged map has one point per voxel of this edge and robot.");
  table.Add("drop_gone", &composer.drop_gone,
            "Points leave the merged map that other looks went through: people, cars, what was "
            "taken away. `isthmus export --dynamic` has them.");
  composition::OccupancyOptions& occupancy = config.pipeline.occupancy;
  table.Add("octomap_max_range_m", &occupancy.max_range_m, 1.0, 1000.0,
            "Rays of an OctoMap are cut here.");
  table.Add("octomap_cache_mb", &config.pipeline.octomap_cache_mb, 0, 1'000'000,
            "Memory for what rays found, MiB, kept from one OctoMap to the next, so that only "
            "what changed is cast again; 0: all is, every time.");
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
