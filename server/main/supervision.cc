#include "server/main/supervision.h"

#include <signal.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <utility>
#include <vector>

#include "server/main/certificate_warnings.h"
#include "server/main/listener_watch.h"

namespace isthmus::server {
namespace {

using std::chrono::milliseconds;

// How long a listener may take to answer: a busy machine is no deaf one.
constexpr milliseconds kPatience{5000};
constexpr milliseconds kCertificatePeriod{60'000};
// A listener is deaf when so many probes in a row had no answer.
constexpr int kMaxFailures = 4;

// The next probe's time since the last; zero: none is wanted.
milliseconds ProbePeriod(int limit_s, milliseconds watchdog) {
  const milliseconds own(limit_s * 1000 / kMaxFailures);
  const milliseconds asked = watchdog / 2;
  if (own.count() == 0 || asked.count() == 0) return std::max(own, asked);
  return std::min(own, asked);
}

}  // namespace

Supervision::Supervision(const ServerConfig& config, const std::string& address,
                         std::function<void(const std::string& trouble)> on_certificate)
    : manager_(ServiceManager::FromEnvironment()) {
  manager_.Tell("READY=1\nSTATUS=Listening on " + address);
  WatchListener(config.listener_watchdog_s, address);
  std::vector<std::string> certificates;
  for (const std::string& path : {config.rpc.tls.certificate, config.rpc.tls.client_ca}) {
    if (!path.empty()) certificates.push_back(path);
  }
  if (certificates.empty()) return;
  auto warnings = std::make_shared<CertificateWarnings>(
      certificates,
      [told = std::move(on_certificate)](const std::string& trouble) {
        spdlog::warn("{}", trouble);
        told(trouble);
      },
      [](const std::string& news) { spdlog::info("{}", news); });
  certificates_ = std::make_unique<Periodic>("certificates", kCertificatePeriod,
                                             [warnings] { warnings->Check(); });
}

void Supervision::WatchListener(int limit_s, const std::string& address) {
  const milliseconds period = ProbePeriod(limit_s, manager_.watchdog());
  if (period.count() == 0) return;
  ListenerWatch::Options options;
  options.max_failures =
      static_cast<int>((milliseconds(limit_s * 1000) + period - milliseconds(1)) / period);
  options.probe = [address, patience = std::min(kPatience, period)] {
    return ProbeListener(address, patience);
  };
  options.on_answer = [this] { manager_.Tell("WATCHDOG=1"); };
  options.on_silence = [address](const absl::Status& status) {
    spdlog::warn("a connection to its own address {} had no answer: {}", address,
                 std::string(status.message()));
  };
  options.on_deaf = [this, limit_s] {
    was_deaf_ = true;
    spdlog::error(
        "no connection was accepted for {} s, most likely as there were no files left for one, and "
        "that heals with a restart only: ending in good order (network.listener_watchdog_s). "
        "Raise the limit on open files (LimitNOFILE= of systemd, ulimit -Hn)",
        limit_s);
    kill(getpid(), SIGTERM);
  };
  listener_ = std::make_unique<Periodic>(
      "listener_watch", period,
      [watch = std::make_shared<ListenerWatch>(options)] { watch->Probe(); });
}

void Supervision::Stop() {
  listener_.reset();
  certificates_.reset();
  manager_.Tell("STOPPING=1");
}

}  // namespace isthmus::server
