// Reasons that come again and again, of which a person wants to read the first few.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace isthmus::cli {

// Reasons that differ in nothing but numbers (of scans, in names of files) are one. Not thread
// safe.
class ReasonTally {
 public:
  // True if it is one of the first few of its kind, and so worth a line of its own.
  bool Count(const std::string& reason);
  // Each kind with more reasons: its last reason, and the number of times that Count was false.
  std::vector<std::pair<std::string, uint64_t>> Unsaid() const;

 private:
  struct Kind {
    uint64_t count = 0;
    std::string last;
  };
  std::map<std::string, Kind> kinds_;
};

}  // namespace isthmus::cli
