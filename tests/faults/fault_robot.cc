// The program of a robot that dies: pushes its scans from a spool on the disk and says on stdout
// what it was told, a line each:
//   resumed SEQUENCE          where its spool stood
//   pushed SEQUENCE           Push returned OK
//   acked SEQUENCE DURABLE X Y Z   in odom, metres
//   finished                  the session is, and all is durable
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <string>

#include "client/library/client.h"
#include "tests/faults/harness/robot.h"
#include "tests/faults/harness/room_robot.h"

namespace isthmus::faults {
namespace {

// Keeps the robot from running away from its server.
constexpr uint64_t kSpoolBytes = 32u << 20;

struct Arguments {
  std::string address, spool, stop_file;
  int robot = 0;
};

// One write each: a line is there whole or not at all, whenever the program dies.
void Say(const std::string& line) { dprintf(1, "%s\n", line.c_str()); }

void SayAck(const ScanAck& ack) {
  if (!ack.T_odom_sensor) return Say("told of " + std::to_string(ack.sequence));
  const Eigen::Vector3d at = ack.T_odom_sensor->translation();
  dprintf(1, "acked %llu %llu %.17g %.17g %.17g\n", static_cast<unsigned long long>(ack.sequence),
          static_cast<unsigned long long>(ack.durable_sequence), at.x(), at.y(), at.z());
}

int Fail(const absl::Status& status) {
  std::fprintf(stderr, "fault_robot: %s\n", status.ToString().c_str());
  return 1;
}

int Run(const Arguments& arguments) {
  client::ClientOptions where = PatientClient(arguments.address);
  where.require_server = false;
  const auto client = client::Client::Connect(where);
  if (!client.ok()) return Fail(client.status());
  client::ScanStreamOptions options;
  options.spool_dir = arguments.spool;
  options.spool.max_bytes = kSpoolBytes;
  options.on_ack = SayAck;
  options.on_event = [](const std::string& event) { std::fprintf(stderr, "%s\n", event.c_str()); };
  auto stream = (*client)->OpenSpool({RobotId(RobotName(arguments.robot)), "vlp16"}, options);
  if (!stream.ok()) return Fail(stream.status());
  uint64_t scan = (*stream)->resumed().last_sequence;
  Say("resumed " + std::to_string(scan));
  while (!std::filesystem::exists(arguments.stop_file)) {
    ++scan;
    const absl::Status pushed = (*stream)->Push(RobotStamp(scan), RobotScan(arguments.robot, scan));
    if (!pushed.ok()) return Fail(pushed);
    Say("pushed " + std::to_string(scan));
  }
  const auto finished = (*stream)->FinishSession();
  if (!finished.ok()) return Fail(finished.status());
  Say("finished");
  return 0;
}

}  // namespace
}  // namespace isthmus::faults

int main(int argc, char** argv) {
  isthmus::faults::Arguments arguments;
  CLI::App app("A robot that dies.", "fault_robot");
  app.add_option("--address", arguments.address)->required();
  app.add_option("--spool", arguments.spool)->required();
  app.add_option("--stop-file", arguments.stop_file, "It stops once this is there")->required();
  app.add_option("--robot", arguments.robot)->check(CLI::Range(0, 3));
  CLI11_PARSE(app, argc, argv);
  return isthmus::faults::Run(arguments);
}
