// The news of a link that is tried again and again: each reason once, and the end.
#pragma once

#include <absl/status/status.h>

#include <set>
#include <string>

namespace isthmus::client {

// Not thread safe. Times are seconds of one clock.
class Outage {
 public:
  // A link ended so, and will be opened again. What to tell of it; empty: that was told before.
  // Reasons are the same where their codes are, as texts of one reason differ from time to time.
  std::string Failed(const absl::Status& why, double now_s);
  // The server took something. What to tell; empty: nothing had failed.
  std::string Ended(double now_s);

 private:
  std::set<absl::StatusCode> told_;
  double since_s_ = 0;  // Time of the first failure.
  int failures_ = 0;
};

}  // namespace isthmus::client
