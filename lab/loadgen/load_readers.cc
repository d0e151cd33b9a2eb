#include "lab/loadgen/load_readers.h"

#include <chrono>
#include <memory>
#include <random>
#include <utility>

#include "client/library/client.h"
#include "core/stopwatch.h"
#include "lab/loadgen/limits.h"

namespace isthmus::loadgen {
namespace {

// The surroundings of a robot that has a place in the map; a corner of it where none has.
RegionQuery Somewhere(const std::vector<SessionStatus>& sessions, std::mt19937_64& random) {
  RegionQuery query;
  query.sphere = {Eigen::Vector3d::Zero(), kReaderRadiusM};
  std::vector<const SessionStatus*> placed;
  for (const SessionStatus& session : sessions) {
    if (session.T_map_odom && session.component) placed.push_back(&session);
  }
  if (placed.empty()) return query;
  const SessionStatus& one = *placed[random() % placed.size()];
  query.sphere->center = one.T_map_odom->translation();
  query.component = *one.component;
  return query;
}

}  // namespace

LoadReaders::LoadReaders(const std::string& server, int readers, double period_s) {
  for (int i = 0; i < readers; ++i) {
    threads_.emplace_back(
        [this, server, period_s, i] { Read(server, period_s, static_cast<uint64_t>(i)); });
  }
}

LoadReaders::~LoadReaders() {
  stopping_ = true;
  for (std::thread& thread : threads_) thread.join();
}

void LoadReaders::Read(const std::string& server, double period_s, uint64_t seed) {
  std::mt19937_64 random(seed);
  client::ClientOptions options;
  options.address = server;
  options.require_server = false;
  options.backoff.max_attempts = 1;
  options.call_timeout_s = options.transfer_timeout_s = kReaderTimeoutS;
  const auto client = client::Client::Connect(options);
  if (!client.ok()) return;
  std::vector<SessionStatus> sessions;
  const auto ask = [&](const char* name, const auto& call) {
    if (stopping_) return;
    const Stopwatch watch;
    const absl::Status status = call();
    const double ms = watch.Ms();
    {
      MutexLock lock(&mutex_);
      ReaderResult& result = results_[name];
      if (status.ok()) result.ms.push_back(ms);
      if (!status.ok()) ++result.errors[std::string(status.message())];
    }
    std::this_thread::sleep_for(std::chrono::duration<double>(period_s));
  };
  while (!stopping_) {
    ask("map state", [&] { return (*client)->GetMapInfo().status(); });
    ask("sessions", [&]() -> absl::Status {
      auto list = (*client)->ListSessions();
      if (!list.ok()) return list.status();
      sessions = *std::move(list);
      return absl::OkStatus();
    });
    ask("points within 30 m", [&] {
      const absl::Status status = (*client)->QueryRegion(Somewhere(sessions, random),
                                                         [](const RegionChunk&) { return true; });
      // Before the first merge there may be nothing to read.
      return absl::IsNotFound(status) ? absl::OkStatus() : status;
    });
  }
}

std::map<std::string, ReaderResult> LoadReaders::Results() const {
  MutexLock lock(&mutex_);
  return results_;
}

}  // namespace isthmus::loadgen
