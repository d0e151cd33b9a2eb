#include "tests/faults/client_kills.h"

#include <absl/strings/str_cat.h>
#include <signal.h>

#include <chrono>
#include <fstream>
#include <random>
#include <sstream>
#include <thread>

#include "tests/faults/harness/room_robot.h"

namespace isthmus::faults {
namespace {

// The output of one robot's programs, one after the other.
struct Told {
  uint64_t pushed = 0, lost_pushed = 0;
  std::map<uint64_t, Eigen::Vector3d> poses;  // T_odom_sensor's translation, as acknowledged.
  uint64_t moved = 0;                         // Told of again, and otherwise.
  std::vector<std::string> broken;
};

// Starts one robot's program, kills it, starts it again.
class Tormentor {
 public:
  Tormentor(const Setup& setup, const ClientKillOptions& options, const std::string& folder,
            const std::string& address, int robot, int kills)
      : options_(options),
        program_(setup.robot),
        folder_(folder),
        name_(RobotName(robot)),
        robot_(robot),
        address_(address),
        kills_(kills),
        random_(1000 * setup.seed + static_cast<uint64_t>(robot)) {}

  Told Run() {
    for (int kill = 0; kill < kills_ && told_.broken.empty(); ++kill) {
      Launch();
      if (kill % options_.startup_every != 0) {
        const uint64_t scans =
            std::uniform_int_distribution<uint64_t>(1, options_.max_scans)(random_);
        for (uint64_t pushed = 0; pushed < scans;) {
          const std::string line = process_->ReadLine();
          if (line.empty()) return Died();
          pushed += Take(line);
        }
      }
      Delay(60'000);
      process_->Signal(SIGKILL);
      ReadRest();
    }
    std::ofstream(StopFile()) << "stop";
    Launch();
    if (ReadRest() != 0 || !is_finished_) return Died();
    return told_;
  }

 private:
  std::string StopFile() const { return absl::StrCat(folder_, "/", name_, ".stop"); }

  void Launch() {
    process_ = std::make_unique<ChildProcess>(
        program_,
        std::vector<std::string>{"--address", address_, "--robot", std::to_string(robot_),
                                 "--spool", absl::StrCat(folder_, "/", name_, ".spool"),
                                 "--stop-file", StopFile()},
        absl::StrCat(folder_, "/", name_, ".log"));
  }

  void Delay(int max_us) {
    std::this_thread::sleep_for(
        std::chrono::microseconds(std::uniform_int_distribution<int>(0, max_us)(random_)));
  }

  // Counts the output from before it died. Returns the exit code.
  int ReadRest() {
    for (std::string line = process_->ReadLine(); !line.empty(); line = process_->ReadLine()) {
      Take(line);
    }
    return process_->Wait();
  }

  // True if it was a scan pushed.
  bool Take(const std::string& line) {
    std::istringstream in(line);
    std::string word;
    uint64_t sequence = 0;
    in >> word >> sequence;
    if (word == "resumed" && sequence < told_.pushed) told_.lost_pushed += told_.pushed - sequence;
    if (word == "resumed" || word == "pushed") told_.pushed = sequence;
    if (word == "acked") {
      uint64_t durable = 0;
      Eigen::Vector3d at;
      in >> durable >> at.x() >> at.y() >> at.z();
      const auto [it, is_new] = told_.poses.emplace(sequence, at);
      told_.moved += !is_new && it->second != at;
    }
    is_finished_ |= word == "finished";
    return word == "pushed";
  }

  Told Died() {
    told_.broken.push_back(absl::StrCat(name_, " died: ", process_->Errors()));
    return told_;
  }

  const ClientKillOptions options_;
  const std::string program_, folder_, name_;
  const int robot_;
  const std::string address_;
  const int kills_;
  std::mt19937_64 random_;
  std::unique_ptr<ChildProcess> process_;
  Told told_;
  bool is_finished_ = false;
};

void CheckTold(const Told& told, const StoredSession& stored, Report& report) {
  report.scans += told.pushed;
  report.lost_pushed += told.lost_pushed;
  report.moved_poses += told.moved;
  for (const std::string& broken : told.broken) report.Break(broken);
  for (const TrajectoryEntry& entry : stored.trajectory) {
    const auto it = told.poses.find(entry.sequence);
    if (it == told.poses.end()) continue;  // Its acknowledgement died with the program.
    report.moved_poses += (it->second - entry.T_odom_sensor.translation()).norm() > kSamePoseM;
  }
}

}  // namespace

Report KillClients(const Setup& setup, const ClientKillOptions& options) {
  const double begin_s = NowS();
  Report report;
  report.name = "kill -9 of the client";
  report.faults =
      absl::StrCat(options.kills, " kills, ", setup.robots, " robots, seed ", setup.seed);
  const auto server = NewServer(setup, "client_kills");
  std::vector<Told> told(static_cast<size_t>(setup.robots));
  std::vector<std::thread> threads;
  for (int i = 0; i < setup.robots; ++i) {
    const int kills = options.kills / setup.robots + (i < options.kills % setup.robots ? 1 : 0);
    threads.emplace_back([&, i, kills] {
      told[static_cast<size_t>(i)] =
          Tormentor(setup, options, server->folder(), server->address(), i, kills).Run();
    });
  }
  for (std::thread& thread : threads) thread.join();
  EndServer(*server, report);
  StoredMap map = ReadStoredMap(server->data());
  std::vector<uint64_t> scans;
  for (int i = 0; i < setup.robots; ++i) {
    const Told& robot = told[static_cast<size_t>(i)];
    CheckTold(robot, map[SessionId(absl::StrCat(RobotName(i), "-1"))], report);
    scans.push_back(robot.pushed);
  }
  CheckMap(setup, scans, map, report);
  report.seconds = NowS() - begin_s;
  return report;
}

}  // namespace isthmus::faults
