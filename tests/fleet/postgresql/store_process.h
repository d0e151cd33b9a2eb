// A process that has a site in PostgreSQL open and writes to it, as a server does: to be killed,
// paused and cut off.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <optional>
#include <string>
#include <vector>

namespace isthmus::storage {

struct StoreProcessOptions {
  std::string url, site;
  std::string name = "owner";  // Writes sessions NAME-1, NAME-2 ...
  std::chrono::milliseconds lease{1000};
  bool stands_by = true;
  // Lead of its wall clock; its monotonic clock is right.
  std::chrono::seconds clock_ahead{0};
};

// The exit code of one that was told that it lost the site.
inline constexpr int kLostTheSite = 5;

// Make it while the test has no threads: it forks. Kills what still runs in the end. Not thread
// safe.
class StoreProcess {
 public:
  explicit StoreProcess(const StoreProcessOptions& options);
  ~StoreProcess();
  StoreProcess(const StoreProcess&) = delete;
  StoreProcess& operator=(const StoreProcess&) = delete;

  // The next session of which its store said that it is stored; nothing once it has ended.
  std::optional<std::string> Next();
  // The sessions that it told of and Next has not returned.
  std::vector<std::string> Rest();
  void Signal(int signal) const;
  // The exit code, or 128 + the signal that ended it.
  int Wait();

 private:
  pid_t pid_ = -1;
  int told_ = -1;
};

}  // namespace isthmus::storage
