#include "tests/faults/harness/fleet.h"

#include <absl/strings/str_cat.h>

#include <filesystem>
#include <stdexcept>

#include "tests/faults/harness/room_robot.h"

namespace isthmus::faults {
Fleet::Fleet(const Setup& setup, const FleetOptions& given) {
  for (int i = 0; i < setup.robots; ++i) {
    const auto index = static_cast<size_t>(i);
    RobotOptions options;
    options.robot = i;
    options.address = given.addresses[index % given.addresses.size()];
    options.scans = given.scans.empty() ? 0 : given.scans[index];
    options.period_s = given.period_s;
    if (!given.spools.empty()) {
      options.stream.spool_dir = absl::StrCat(given.spools, "/", RobotName(i));
      std::filesystem::create_directories(options.stream.spool_dir);
    }
    robots_.push_back(std::make_unique<Robot>(options, &acks_));
  }
}

void Fleet::Drive() {
  for (const auto& robot : robots_) robot->Drive();
}

void Fleet::Stop() {
  for (const auto& robot : robots_) robot->Stop();
}

void Fleet::Finish(Report& report) {
  for (const auto& robot : robots_) {
    if (const absl::Status status = robot->Finish(); !status.ok()) {
      report.Break(absl::StrCat("robot of ", robot->session().value(), ": ", status.ToString()));
    }
  }
}

std::vector<uint64_t> Fleet::pushed() const {
  std::vector<uint64_t> scans;
  for (const auto& robot : robots_) scans.push_back(robot->pushed());
  return scans;
}

uint64_t LostDurable(const std::vector<std::unique_ptr<Robot>>& robots, const std::string& address,
                     Report& report) {
  uint64_t lost = 0;
  auto client = client::Client::Connect(PatientClient(address));
  for (const auto& robot : robots) {
    const uint64_t told = robot->durable();
    const auto session = client.ok() ? (*client)->GetSession(robot->session()) : client.status();
    if (!session.ok()) {
      report.Break(absl::StrCat("after a restart: ", session.status().ToString()));
    } else if (session->durable_sequence < told) {
      lost += told - session->durable_sequence;
    }
  }
  return lost;
}

void CheckAcks(const Fleet& fleet, const StoredMap& map, Report& report) {
  for (const auto& robot : fleet.robots()) {
    report.scans += robot->pushed();
    std::map<uint64_t, Pose> stored;
    if (const auto it = map.find(robot->session()); it != map.end()) {
      for (const TrajectoryEntry& entry : it->second.trajectory) {
        stored[entry.sequence] = entry.T_odom_sensor;
      }
    }
    uint64_t expected = 1;
    for (const ScanAck& ack : robot->acks()) {
      if (ack.sequence < expected) ++report.duplicates;
      if (ack.sequence > expected) report.Break(absl::StrCat("no word of scan ", expected));
      expected = ack.sequence + 1;
      if (ack.outcome == ScanOutcome::kRejected) {
        report.Break(absl::StrCat("scan ", ack.sequence, " rejected: ", ack.reason));
      }
      if (!ack.T_odom_sensor || ack.tracking == Tracking::kLost) continue;
      const auto found = stored.find(ack.sequence);
      if (found == stored.end()) {
        ++report.lost_pushed;
      } else if ((found->second.translation() - ack.T_odom_sensor->translation()).norm() >
                 kSamePoseM) {
        ++report.moved_poses;
      }
    }
    if (expected <= robot->pushed()) report.Break(absl::StrCat("no word of scan ", expected));
  }
}

std::unique_ptr<ServerProcess> NewServer(const Setup& setup, const std::string& name) {
  const std::string folder = setup.folder + "/" + name;
  std::filesystem::remove_all(folder);
  auto server = std::make_unique<ServerProcess>(setup.server, folder, 8, "", setup.store);
  if (!server->Start()) throw std::runtime_error(absl::StrCat("no server: ", server->Log()));
  return server;
}

void EndServer(ServerProcess& server, Report& report) {
  if (server.Stop() != 0) report.Break(absl::StrCat("the server ended ill: ", server.Log()));
}

void Conclude(const Setup& setup, ServerProcess& server, Fleet& fleet, Report& report) {
  fleet.Stop();
  if (server.is_running()) {
    fleet.Finish(report);
    EndServer(server, report);
  }
  const StoredMap map = ReadStoredMap(server.data(), setup.store);
  CheckAcks(fleet, map, report);
  CheckMap(setup, fleet.pushed(), map, report);
}

StoredMap UndisturbedMap(const Setup& given, const std::vector<uint64_t>& scans) {
  Setup setup = given;
  setup.store.clear();  // The database is the disturbed one's.
  const auto server = NewServer(setup, "undisturbed");
  Report report;
  {
    Fleet fleet(setup, {.addresses = {server->address()}, .scans = scans});
    fleet.Drive();
    fleet.Finish(report);
  }
  EndServer(*server, report);
  if (!report.broken.empty())
    throw std::runtime_error(absl::StrCat("undisturbed: ", report.broken.front()));
  return ReadStoredMap(server->data());
}

void CheckMap(const Setup& setup, const std::vector<uint64_t>& scans, const StoredMap& map,
              Report& report) {
  const StoredMap wanted = UndisturbedMap(setup, scans);
  for (const auto& [id, session] : wanted) report.submaps_wanted += session.submaps.size();
  report.map = Compare(wanted, map);
  report.Judge();
}

}  // namespace isthmus::faults
