#include "server/main/standby.h"

#include <absl/strings/str_cat.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <cstdlib>
#include <optional>

#include "core/concurrency/thread_role.h"
#include "server/main/log.h"

namespace isthmus::server {
namespace {

// Time between two looks for the end of the wait.
constexpr std::chrono::milliseconds kTick{100};

}  // namespace

Standby::Standby(StopSignal* signal)
    : signal_(signal), manager_(ServiceManager::FromEnvironment()), thread_([this] { Attend(); }) {}

Standby::~Standby() {
  is_over_ = true;
  thread_.join();
}

void Standby::Note(const std::string& why) {
  MutexLock lock(&mutex_);
  if (why == why_) return;
  const bool is_first = why_.empty();
  why_ = why;
  spdlog::info("standing by: {}", why);
  manager_.Tell(absl::StrCat(is_first ? "READY=1\n" : "", "STATUS=Standing by: ", why));
}

void Standby::Attend() {
  NameThread("standby");
  auto told = std::chrono::steady_clock::now();
  while (!is_over_) {
    if (const std::optional<std::string> name = signal_->WaitFor(kTick, OnHangup)) {
      spdlog::info("{} received before the server began to serve: it ends at once", *name);
      manager_.Tell("STOPPING=1");
      std::_Exit(0);
    }
    // A server that is ready has to give signs of life, also while it reads a large map.
    const auto now = std::chrono::steady_clock::now();
    if (manager_.watchdog().count() == 0 || now - told < manager_.watchdog() / 2) continue;
    manager_.Tell("WATCHDOG=1");
    told = now;
  }
}

void EndTakenOver(const std::string& why, int exit_code) {
  spdlog::error("{}. This server ends at once and acknowledges nothing more", why);
  ServiceManager::FromEnvironment().Tell("STOPPING=1");
  std::_Exit(exit_code);
}

}  // namespace isthmus::server
