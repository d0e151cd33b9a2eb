// Robots that stand still with their link open: each has sent one scan and sends no other.
#pragma once

#include <absl/status/statusor.h>

#include <memory>
#include <string>
#include <vector>

#include "client/library/client.h"
#include "lab/loadgen/drives.h"

namespace isthmus::loadgen {

// Not thread safe.
class IdleRobots {
 public:
  // Opens so many sessions, each over a connection of its own, one after the other. The first
  // error.
  static absl::StatusOr<std::unique_ptr<IdleRobots>> Open(const std::string& server, int count,
                                                          const Drive& drive);

 private:
  struct One {
    std::unique_ptr<client::Client> client;
    std::unique_ptr<client::ScanStream> stream;  // Goes before its client.
  };
  std::vector<One> robots_;
};

}  // namespace isthmus::loadgen
