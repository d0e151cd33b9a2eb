#include "server/metrics/server_values.h"

#include "core/io/process_use.h"
#include "server/metrics/prometheus_values.h"

namespace isthmus::metrics {

// The names of what a process takes are those that Prometheus' own libraries use.
void AddServer(const std::string& version, int64_t started_ns, Values* values) {
  values->Gauge("isthmus_build_info", "Always 1; which version runs is in its label.", 1,
                {{"version", version}});
  const ProcessUse use = io::UseOfThisProcess();
  values->Counter("process_cpu_seconds_total", "Computing time of all threads.", use.cpu_s);
  values->Gauge("process_start_time_seconds", "When the process started, Unix time.",
                1e-9 * static_cast<double>(started_ns));
  values->Gauge("process_resident_memory_bytes", "Memory that the process holds.",
                static_cast<double>(use.resident_bytes));
  values->Gauge("process_threads", "Threads of the process.", static_cast<double>(use.threads));
  values->Gauge("process_open_fds", "Open files, connections included.",
                static_cast<double>(use.open_files));
  values->Gauge("process_max_fds", "Most files that may be open.",
                static_cast<double>(use.open_files_limit));
}

}  // namespace isthmus::metrics
