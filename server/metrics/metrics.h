// The server's metrics, which Prometheus fetches over HTTP; docs/metrics.md has the meaning of
// each.
#pragma once

#include <absl/status/status.h>

#include <memory>
#include <string>
#include <vector>

#include "core/stage_observer.h"
#include "server/metrics/metrics_options.h"
#include "server/pipeline.h"

namespace isthmus::metrics {

struct MeasuredSite {
  std::string name;
  server::Pipeline* pipeline = nullptr;
};

// Thread safe.
class Metrics {
 public:
  // `version` is the server's, which starts just now.
  Metrics(const MetricsOptions& options, const std::string& version);
  ~Metrics();  // Stop().

  // Counts the work of a site; the same one each time, as long as this lives.
  StageObserver* ObserverOf(const std::string& site);
  void NoteCall(const std::string& method, absl::StatusCode code, double seconds) noexcept;

  // Serves them at MetricsOptions::listen until Stop; the pipelines must live until then. Call
  // once. A scrape takes no lock that scans wait for longer than a number is read. Errors of
  // CheckListening; Unavailable where the address is in use.
  absl::Status Serve(std::vector<MeasuredSite> sites);
  // The address of the page, with the port filled in; empty while there is none.
  std::string address() const;
  void Stop();

  // The text of a scrape, in Prometheus' format.
  std::string Text() const;

 private:
  struct State;
  const std::unique_ptr<State> state_;
};

}  // namespace isthmus::metrics
