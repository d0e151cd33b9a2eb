#include "tests/faults/harness/damage.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <sstream>
#include <stdexcept>

#include "storage/sqlite/sqlite.h"
#include "tests/faults/harness/room_robot.h"

namespace isthmus::faults {
namespace {

namespace fs = std::filesystem;

constexpr size_t kPage = 4096, kSector = 512;
constexpr int kDamagedExit = 128;  // Exit codes from here on are signals.

std::string ReadFile(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return std::string(std::istreambuf_iterator<char>(in), {});
}

void WriteFile(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

// Somewhere in a file, by the seed.
class Vandal {
 public:
  Vandal(const std::string& folder, uint64_t seed)
      : database_(folder + "/isthmus.db"), log_(database_ + "-wal"), random_(seed) {}

  void Do(Damage damage) {
    switch (damage) {
      case Damage::kSubmapBits:
        return FlipSubmap();
      case Damage::kPageBits:
        EmptyLog();
        for (int i = 0; i < 3; ++i) FlipBits(database_, kPage, 4);
        return;
      case Damage::kTornPage:
        EmptyLog();
        return TearPage();
      case Damage::kLogBits:
        return FlipBits(log_, 0, 8);
      case Damage::kTornLog:
        return fs::resize_file(log_, Below(fs::file_size(log_)));
      case Damage::kMissingLog:
        fs::remove(log_);
        fs::remove(database_ + "-shm");
        return;
      case Damage::kTruncated:
        EmptyLog();
        return fs::resize_file(database_, kPage + Below(fs::file_size(database_) - kPage));
      case Damage::kEmptyDatabase:
        return fs::resize_file(database_, 0);
      case Damage::kNoise: {
        std::string bytes = ReadFile(database_);
        for (char& byte : bytes) byte = static_cast<char>(random_());
        return WriteFile(database_, bytes);
      }
    }
  }

 private:
  uint64_t Below(uint64_t end) {
    return std::uniform_int_distribution<uint64_t>(0, end - 1)(random_);
  }

  // Leaves the log where it is when it is closed, as the server that died did.
  std::unique_ptr<storage::SqliteConnection> Open() const {
    auto database = storage::SqliteConnection::Open(database_);
    if (!database.ok()) throw std::runtime_error(database.status().ToString());
    const absl::Status status = (*database)->SetCheckpointOnClose(false);
    if (!status.ok()) throw std::runtime_error(status.ToString());
    return *std::move(database);
  }

  // Pages that the log repeats would hide the damage in the database.
  void EmptyLog() const {
    const absl::Status status = Open()->Execute("PRAGMA wal_checkpoint(TRUNCATE)");
    if (!status.ok()) throw std::runtime_error(status.ToString());
  }

  // A burst within one page behind `from`.
  void FlipBits(const std::string& path, uint64_t from, int bits) {
    std::string bytes = ReadFile(path);
    const uint64_t at = from + Below(bytes.size() - from);
    for (int i = 0; i < bits; ++i) {
      const uint64_t where = std::min<uint64_t>(bytes.size() - 1, at + Below(64));
      bytes[where] = static_cast<char>(bytes[where] ^ (1 << Below(8)));
    }
    WriteFile(path, bytes);
  }

  void TearPage() {
    std::string bytes = ReadFile(database_);
    const uint64_t page = 1 + Below(bytes.size() / kPage - 1);
    const uint64_t sectors = 1 + Below(kPage / kSector - 1);
    bytes.replace(page * kPage, sectors * kSector, sectors * kSector, '\0');
    WriteFile(database_, bytes);
  }

  // Through SQLite, so that nothing but the blob is wrong.
  void FlipSubmap() {
    const auto database = Open();
    auto rows = database->Prepare("SELECT submap, data FROM submap_blobs");
    std::vector<std::pair<int64_t, std::string>> blobs;
    while (*rows.Step()) blobs.emplace_back(rows.Int(0), rows.Text(1));
    auto& [submap, data] = blobs[Below(blobs.size())];
    const uint64_t at = Below(data.size());
    data[at] = static_cast<char>(data[at] ^ (1 << Below(8)));
    const absl::Status status =
        database->Prepare("UPDATE submap_blobs SET data = ? WHERE submap = ?")
            .BindBlob(data)
            .Bind(submap)
            .Run();
    if (!status.ok()) throw std::runtime_error(status.ToString());
  }

  const std::string database_, log_;
  std::mt19937_64 random_;
};

// Everything a reader may ask. The answer may be an error, but it has to come.
void AskEverything(client::Client& client, const std::string& folder, DamageTrial& trial) {
  const auto answered = [&](const char* what, const absl::Status& status) {
    if (absl::IsUnavailable(status) || absl::IsDeadlineExceeded(status)) {
      trial.broken.push_back(absl::StrCat(what, ": ", status.ToString()));
    }
  };
  answered("ListSessions", client.ListSessions().status());
  answered("GetMapInfo", client.GetMapInfo().status());
  const auto submaps = client.ListSubmaps();
  answered("ListSubmaps", submaps.status());
  if (submaps.ok()) trial.submaps = submaps->size();
  answered("QueryRegion", client.QueryRegion({}, [&](const RegionChunk& chunk) {
    trial.points += chunk.points.size();
    return true;
  }));
  answered("Export", client.ExportToFile({}, folder + "/map.pcd").status());
  for (const std::string robot : {"r0", "r1"}) {
    for (const TrajectoryFrame frame : {TrajectoryFrame::kOdom, TrajectoryFrame::kMap}) {
      answered("GetTrajectory", client.GetTrajectory(RobotId(robot), frame).status());
    }
  }
}

// A robot that comes anew. Its scans may be refused, with a reason.
void PushNewScans(const std::string& address, DamageTrial& trial) {
  try {
    RobotOptions options;
    options.robot = 2;
    options.address = address;
    options.scans = 10;
    Robot robot(options, nullptr);
    robot.Drive();
    const absl::Status status = robot.Finish();
    if (absl::IsUnavailable(status)) trial.broken.push_back("new scans: " + status.ToString());
  } catch (const std::runtime_error& error) {
    trial.words = error.what();
  }
}

std::string FirstComplaint(const std::string& log) {
  std::istringstream in(log);
  for (std::string line; std::getline(in, line);) {
    if (line.find(" error ") != std::string::npos || line.find(" warning ") != std::string::npos) {
      return line.substr(std::min<size_t>(line.size(), 24));
    }
  }
  return {};
}

int Check(const Setup& setup, const std::string& data, DamageTrial& trial) {
  ChildProcess check(setup.server, {"--data", data, "--check"}, data + "/check.log");
  const std::string text = check.ReadAll();
  const int code = check.Wait();
  if (code >= kDamagedExit) trial.broken.push_back(absl::StrCat("--check crashed: ", code));
  return code;
}

}  // namespace

const std::vector<Damage>& AllDamages() {
  static const std::vector<Damage> all = {
      Damage::kSubmapBits, Damage::kPageBits,      Damage::kTornPage,
      Damage::kLogBits,    Damage::kTornLog,       Damage::kMissingLog,
      Damage::kTruncated,  Damage::kEmptyDatabase, Damage::kNoise};
  return all;
}

std::string ToString(Damage damage) {
  constexpr const char* kNames[] = {"bits flipped in a submap",
                                    "bits flipped in pages",
                                    "torn page",
                                    "bits flipped in the log",
                                    "torn log",
                                    "missing log",
                                    "truncated database",
                                    "empty database",
                                    "noise"};
  return kNames[static_cast<int>(damage)];
}

std::string MakeDamageMaster(const Setup& setup) {
  const auto server = NewServer(setup, "master");
  Setup two = setup;
  two.robots = 2;
  Report report;
  {
    Fleet fleet(two, {.addresses = {server->address()}, .scans = {40, 44}});
    fleet.Drive();
    fleet.Finish(report);
    server->Kill();
  }
  if (!report.broken.empty()) throw std::runtime_error(report.broken.front());
  return server->data();
}

DamageTrial TryDamage(const Setup& setup, const std::string& master, Damage damage, uint64_t seed) {
  DamageTrial trial;
  trial.damage = damage;
  trial.seed = seed;
  const std::string folder = setup.folder + "/damaged";
  fs::remove_all(folder);
  fs::create_directories(folder);
  ServerProcess server(setup.server, folder);
  fs::copy(master, server.data());
  Vandal(server.data(), seed).Do(damage);
  const int checked = Check(setup, server.data(), trial);
  server.Launch();
  trial.is_up = server.WaitUntilUp();
  if (trial.is_up) {
    server.Publish();
    const auto client = client::Client::Connect(PatientClient(server.address()));
    if (client.ok()) AskEverything(**client, folder, trial);
    PushNewScans(server.address(), trial);
    if (server.Stop() >= kDamagedExit) trial.broken.push_back("crashed");
  } else if (server.exit_code() >= kDamagedExit) {
    trial.broken.push_back(absl::StrCat("crashed at its start: ", server.exit_code()));
  }
  const std::string words = FirstComplaint(server.Log());
  if (!words.empty()) trial.words = words;
  trial.is_reported = checked != 0 || !words.empty();
  if (!trial.is_up && words.empty()) trial.broken.push_back("refused without a word");
  return trial;
}

Report DamageFolders(const Setup& setup, int seeds) {
  const double begin_s = NowS();
  Report report;
  report.name = "damaged folders";
  const std::string master = MakeDamageMaster(setup);
  for (const Damage damage : AllDamages()) {
    int up = 0, told = 0;
    uint64_t submaps = 0;
    for (int i = 0; i < seeds; ++i) {
      const uint64_t seed = setup.seed + static_cast<uint64_t>(i);
      const DamageTrial trial = TryDamage(setup, master, damage, seed);
      up += trial.is_up;
      told += trial.is_reported;
      submaps += trial.submaps;
      for (const std::string& broken : trial.broken) {
        report.Break(absl::StrCat(ToString(damage), ", seed ", seed, ": ", broken));
      }
    }
    report.figures.push_back(
        absl::StrFormat("%s: %d of %d served (%.1f submaps), %d reported", ToString(damage), up,
                        seeds, up == 0 ? 0.0 : static_cast<double>(submaps) / up, told));
  }
  report.faults = absl::StrCat(AllDamages().size(), " kinds x ", seeds, " seeds");
  report.seconds = NowS() - begin_s;
  return report;
}

}  // namespace isthmus::faults
