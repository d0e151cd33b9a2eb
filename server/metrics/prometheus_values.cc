#include "server/metrics/prometheus_values.h"

namespace isthmus::metrics {

prometheus::ClientMetric& Values::Add(const char* name, const char* help,
                                      prometheus::MetricType type,
                                      std::initializer_list<Label> labels) {
  prometheus::MetricFamily& family = families_[name];
  if (family.metric.empty()) {
    family.name = name;
    family.help = help;
    family.type = type;
  }
  prometheus::ClientMetric& metric = family.metric.emplace_back();
  if (!site_.empty()) metric.label.push_back({"site", site_});
  for (const auto& [key, value] : labels) metric.label.push_back({key, value});
  return metric;
}

void Values::Gauge(const char* name, const char* help, double value,
                   std::initializer_list<Label> labels) {
  Add(name, help, prometheus::MetricType::Gauge, labels).gauge.value = value;
}

void Values::Counter(const char* name, const char* help, double value,
                     std::initializer_list<Label> labels) {
  Add(name, help, prometheus::MetricType::Counter, labels).counter.value = value;
}

std::vector<prometheus::MetricFamily> Values::Take() {
  std::vector<prometheus::MetricFamily> taken;
  for (auto& [name, family] : families_) taken.push_back(std::move(family));
  families_.clear();
  return taken;
}

}  // namespace isthmus::metrics
