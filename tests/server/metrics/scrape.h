// A scrape as a test looks at it: over a real socket, and what it says taken apart.
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

namespace isthmus::metrics {

// The whole answer, headers included; empty where nobody answers. `address`: "127.0.0.1:PORT".
std::string Ask(const std::string& address, const std::string& request_line);

struct Sample {
  std::string name;
  std::map<std::string, std::string> labels;
  double value = 0;
};

class Scrape {
 public:
  // `answer` may begin with HTTP headers, which are skipped.
  explicit Scrape(const std::string& answer);
  // GET /metrics.
  static Scrape Of(const std::string& address);

  const std::vector<Sample>& samples() const { return samples_; }
  // As HELP lines name them: a histogram without _bucket, _sum and _count.
  const std::set<std::string>& families() const { return families_; }

  // The sum over the samples of that name that have these labels among theirs; NaN where there is
  // none.
  double Sum(const std::string& name, const std::map<std::string, std::string>& labels = {}) const;

 private:
  std::vector<Sample> samples_;
  std::set<std::string> families_;
};

}  // namespace isthmus::metrics
