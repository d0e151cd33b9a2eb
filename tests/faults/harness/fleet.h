// Robots under one server, and what is asked of them in the end.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "tests/faults/harness/report.h"
#include "tests/faults/harness/robot.h"
#include "tests/faults/harness/server_process.h"

namespace isthmus::faults {

// The folders of the programs and of temporary files, and the seed that decides the faults.
struct Setup {
  std::string server;  // isthmus-server.
  std::string robot;   // fault_robot.
  std::string folder;
  int robots = 4;
  uint64_t seed = 1;
  std::string store = {};  // The PostgreSQL database that the map is in; empty: SQLite.
};

// A pose is told and stored as doubles, but turned from quaternion to bytes and back on the way.
inline constexpr double kSamePoseM = 1e-9;

struct FleetOptions {
  std::vector<std::string> addresses;  // One for all, or one for each robot.
  std::vector<uint64_t> scans = {};    // By robot; none: until Stop.
  double period_s = 0;                 // See RobotOptions.
  std::string spools = {};             // Folder of the robots' spools; empty: in memory.
};

class Fleet {
 public:
  // Creates the robots' sessions.
  Fleet(const Setup& setup, const FleetOptions& options);

  void Drive();
  void Stop();
  // Until every scan is acknowledged and every session finished; failures go to `report`.
  void Finish(Report& report);

  const std::vector<std::unique_ptr<Robot>>& robots() const { return robots_; }
  const AckCounter& acks() const { return acks_; }
  std::vector<uint64_t> pushed() const;

 private:
  AckCounter acks_;
  std::vector<std::unique_ptr<Robot>> robots_;
};

// Scans that a robot was told to be durable and that the server at `address`, which has just come
// back, does not call durable.
uint64_t LostDurable(const std::vector<std::unique_ptr<Robot>>& robots, const std::string& address,
                     Report& report);

// Holds what the robots were told against each other and against what is stored: every scan told
// of once and in order, and each where it was told to be.
void CheckAcks(const Fleet& fleet, const StoredMap& map, Report& report);

// The map of the same scans when nothing goes wrong, from a server of its own.
StoredMap UndisturbedMap(const Setup& setup, const std::vector<uint64_t>& scans);

// A running server with an empty map in the folder `name` of the setup's; its old content goes.
// Throws std::runtime_error when it does not start.
std::unique_ptr<ServerProcess> NewServer(const Setup& setup, const std::string& name);

// Stops it politely; its words at a bad end go to `report`.
void EndServer(ServerProcess& server, Report& report);

// Has the robots stop, and finish if the server still runs; stops it, and checks acknowledgements
// and map.
void Conclude(const Setup& setup, ServerProcess& server, Fleet& fleet, Report& report);

// Compares, counts and judges.
void CheckMap(const Setup& setup, const std::vector<uint64_t>& scans, const StoredMap& map,
              Report& report);

}  // namespace isthmus::faults
