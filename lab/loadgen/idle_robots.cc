#include "lab/loadgen/idle_robots.h"

#include <absl/strings/str_cat.h>

#include <utility>

#include "lab/loadgen/limits.h"

namespace isthmus::loadgen {

absl::StatusOr<std::unique_ptr<IdleRobots>> IdleRobots::Open(const std::string& server, int count,
                                                             const Drive& drive) {
  auto robots = std::make_unique<IdleRobots>();
  client::ClientOptions options;
  options.address = server;
  options.backoff.max_attempts = kFirstAttempts;
  for (int i = 0; i < count; ++i) {
    auto client = client::Client::Connect(options);
    if (!client.ok()) return client.status();
    const auto session = (*client)->CreateSession(absl::StrCat("idle_", i), drive.sensor);
    if (!session.ok()) return session.status();
    auto stream = (*client)->OpenScanStream(session->record.id);
    if (!stream.ok()) return stream.status();
    const Drive::OneScan& scan = drive.scans.front();
    if (auto status = (*stream)->Push(scan.end_stamp_ns, scan.payload); !status.ok()) return status;
    robots->robots_.push_back({*std::move(client), *std::move(stream)});
  }
  return robots;
}

}  // namespace isthmus::loadgen
