// Values that are read anew at each scrape, as Prometheus wants them: in families of one name.
#pragma once

#include <prometheus/metric_family.h>

#include <initializer_list>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace isthmus::metrics {

class Values {
 public:
  using Label = std::pair<const char*, std::string>;

  // The site of all that follows, until another is set; empty: none.
  void SetSite(std::string site) { site_ = std::move(site); }

  // May go up and down.
  void Gauge(const char* name, const char* help, double value,
             std::initializer_list<Label> labels = {});
  // Only grows, but for a restart; the name ends in _total.
  void Counter(const char* name, const char* help, double value,
               std::initializer_list<Label> labels = {});

  // In order of their names.
  std::vector<prometheus::MetricFamily> Take();

 private:
  prometheus::ClientMetric& Add(const char* name, const char* help, prometheus::MetricType type,
                                std::initializer_list<Label> labels);

  std::string site_;
  std::map<std::string, prometheus::MetricFamily> families_;
};

}  // namespace isthmus::metrics
