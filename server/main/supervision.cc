#include "server/main/supervision.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <utility>
#include <vector>

#include "server/main/certificate_warnings.h"
#include "server/main/listener_watch.h"

namespace isthmus::server {
namespace {

using std::chrono::milliseconds;

// Time a listener may take to answer: a busy machine is none that is stuck.
constexpr milliseconds kPatience{5000};
constexpr milliseconds kCertificatePeriod{60'000};
}  // namespace

Supervision::Supervision(const ServerConfig& config, const std::string& address,
                         std::function<void(const std::string& trouble)> on_certificate)
    : manager_(ServiceManager::FromEnvironment()) {
  manager_.Tell("READY=1\nSTATUS=Listening on " + address);
  WatchListener(address);
  if (config.rpc.tls.certificate.empty()) return;
  auto warnings = std::make_shared<CertificateWarnings>(
      config.rpc.tls,
      [told = std::move(on_certificate)](const std::string& trouble) {
        spdlog::warn("{}", trouble);
        told(trouble);
      },
      [](const std::string& news) { spdlog::info("{}", news); });
  certificates_ = std::make_unique<Periodic>("certificates", kCertificatePeriod,
                                             [warnings] { warnings->Check(); });
}

void Supervision::WatchListener(const std::string& address) {
  const milliseconds period = manager_.watchdog() / 2;
  if (period.count() == 0) return;
  ListenerWatch::Options options;
  options.probe = [address, patience = std::min(kPatience, period)] {
    return ProbeListener(address, patience);
  };
  options.on_answer = [this] { manager_.Tell("WATCHDOG=1"); };
  options.on_silence = [address](const absl::Status& status) {
    spdlog::warn("a connection to the server's own address {} got no answer: {}", address,
                 std::string(status.message()));
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
