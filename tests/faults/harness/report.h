// The report of a campaign of faults: the faults, and their effect on the map.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "tests/faults/harness/stored_map.h"

namespace isthmus::faults {

struct Report {
  std::string name;
  std::string faults;         // Kinds and numbers of faults.
  uint64_t scans = 0;         // Pushed by all robots.
  uint64_t lost_durable = 0;  // Told to be durable, and not there after a fault.
  uint64_t lost_pushed = 0;   // push() returned for them, and they are not there in the end.
  uint64_t duplicates = 0;    // Took effect twice, or were told of twice.
  uint64_t moved_poses = 0;   // Other in the end than they were told.
  uint64_t submaps_wanted = 0;
  MapDifference map;  // From the undisturbed run.
  // Further figures, as "pose after outage 1.2 s".
  std::vector<std::string> figures;
  // The broken promises; empty if all were kept.
  std::vector<std::string> broken;
  double seconds = 0;  // Wall time, undisturbed run included.

  void Break(const std::string& what) { broken.push_back(what); }
  // Adds to `broken` what the counts above say.
  void Judge();
};

// As rows of a Markdown table, with its head.
std::string ToMarkdown(const std::vector<Report>& reports);

}  // namespace isthmus::faults
