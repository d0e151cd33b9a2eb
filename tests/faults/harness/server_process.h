// The real isthmus-server as robots meet it: it dies, and comes back under the same address.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "tests/server/main/child_process.h"

namespace isthmus::faults {

// Small submaps; the map must not depend on how fast the machine is, so nothing is retired, closed
// or matched twice.
std::string ServerConfigText(int scans_per_submap);

// Not thread safe.
class ServerProcess {
 public:
  // Keeps its sockets, its log and, unless another is named, its data folder in `folder`.
  // With a `store`, the map is in that database.
  ServerProcess(const std::string& program, const std::string& folder, int scans_per_submap = 8,
                const std::string& data = "", const std::string& store = "");

  // Starts it and returns at once.
  void Launch();
  // Waits until it listens, at own_address() only. False, and the process gone, when it ended.
  bool WaitUntilUp();
  // Now it is to be found at address().
  void Publish();
  bool Start();  // All three.

  void Kill();  // As a power cut would; returns when it is gone.
  int Stop();   // Politely; the exit code.
  int Wait();   // For an end of its own accord; the exit code.
  // From now on its files cannot grow beyond `bytes`, as on a full disk; absent: they can.
  void LimitFiles(std::optional<uint64_t> bytes) const;
  // The exit code of the process that ended last; 128 + the signal that ended it.
  int exit_code() const { return exit_code_; }
  bool is_running() const { return process_ != nullptr; }

  const std::string& folder() const { return folder_; }
  const std::string& data() const { return data_; }
  std::string address() const;
  std::string own_address() const;
  // All that it said since it was launched last.
  std::string Log() const { return log_; }

 private:
  int End();

  const std::string program_, folder_, data_, store_;
  std::unique_ptr<ChildProcess> process_;
  std::string log_;
  int exit_code_ = 0;
};

}  // namespace isthmus::faults
