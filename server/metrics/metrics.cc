#include "server/metrics/metrics.h"

#include <absl/strings/str_cat.h>
#include <prometheus/registry.h>
#include <prometheus/text_serializer.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <utility>

#include "core/address.h"
#include "core/clock.h"
#include "core/concurrency/mutex.h"
#include "server/metrics/http_page.h"
#include "server/metrics/prometheus_calls.h"
#include "server/metrics/prometheus_stages.h"
#include "server/metrics/prometheus_values.h"
#include "server/metrics/robot_names.h"
#include "server/metrics/server_values.h"
#include "server/metrics/site_values.h"

namespace isthmus::metrics {
namespace {

constexpr char kTextFormat[] = "text/plain; version=0.0.4; charset=utf-8";

// The counters of one site.
struct CountedSite {
  CountedSite(const std::string& name, int most_robots, prometheus::Registry* registry)
      : robots(static_cast<size_t>(most_robots)), stages(name, &robots, registry) {}
  RobotNames robots;
  StageMetrics stages;
};

}  // namespace

absl::Status CheckListening(const MetricsOptions& options) {
  if (options.listen.empty()) return absl::OkStatus();
  if (absl::Status status = http::CheckTcpAddress("metrics.listen", options.listen); !status.ok()) {
    return status;
  }
  if (options.insecure || IsThisMachine(options.listen)) return absl::OkStatus();
  return absl::FailedPreconditionError(absl::StrCat(
      "at ", options.listen,
      " whoever reaches this machine could read the metrics, names of robots and sites among them: "
      "listen at 127.0.0.1 (metrics.listen) and let Prometheus come through something that asks "
      "who it is, or set metrics.insecure: true where the network itself is safe"));
}

struct Metrics::State {
  State(const MetricsOptions& given, std::string given_version)
      : options(given), version(std::move(given_version)), calls(&registry) {}

  const MetricsOptions options;
  const std::string version;
  const int64_t started_ns = Clock::System().NowNs();
  prometheus::Registry registry;
  CallMetrics calls;
  Mutex mutex;  // Held while something is looked up.
  std::map<std::string, CountedSite> counted ABSL_GUARDED_BY(mutex);
  std::vector<MeasuredSite> sites;       // Set before there is a page.
  std::unique_ptr<http::Listener> page;  // Null while nothing is served.

  CountedSite& Find(const std::string& site) {
    MutexLock lock(&mutex);
    return counted.try_emplace(site, site, options.robots, &registry).first->second;
  }
};

Metrics::Metrics(const MetricsOptions& options, const std::string& version)
    : state_(std::make_unique<State>(options, version)) {}

Metrics::~Metrics() { Stop(); }

StageObserver* Metrics::ObserverOf(const std::string& site) { return &state_->Find(site).stages; }

void Metrics::NoteCall(const std::string& method, absl::StatusCode code, double seconds) noexcept {
  state_->calls.NoteCall(method, code, seconds);
}

absl::Status Metrics::Serve(std::vector<MeasuredSite> sites) {
  if (absl::Status status = CheckListening(state_->options); !status.ok()) return status;
  state_->sites = std::move(sites);
  auto page = ServePage(state_->options.listen, kTextFormat, [this] { return Text(); });
  if (!page.ok()) return page.status();
  state_->page = *std::move(page);
  return absl::OkStatus();
}

std::string Metrics::address() const {
  return state_->page == nullptr ? std::string() : state_->page->address();
}

void Metrics::Stop() { state_->page = nullptr; }

std::string Metrics::Text() const {
  Values values;
  AddServer(state_->version, state_->started_ns, &values);
  for (const MeasuredSite& site : state_->sites) {
    AddSite(site.name, *site.pipeline, &state_->Find(site.name).robots, &values);
  }
  std::vector<prometheus::MetricFamily> families = values.Take();
  // Before the first call there is a family without any.
  std::vector<prometheus::MetricFamily> counted = state_->registry.Collect();
  std::erase_if(counted, [](const auto& family) { return family.metric.empty(); });
  std::move(counted.begin(), counted.end(), std::back_inserter(families));
  return prometheus::TextSerializer().Serialize(families);
}

}  // namespace isthmus::metrics
