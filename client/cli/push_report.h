// The answers of isthmus push.
#pragma once

#include <string>
#include <vector>

#include "client/cli/gnss_anchors.h"
#include "client/console/localise_scans.h"
#include "client/console/push_scans.h"

namespace isthmus::cli {

struct PushReportOptions {
  bool json = false;
  bool finish = true;  // As the push's.
  std::string spool;   // As the push's.
  std::string poses;   // FILE.tum of a robot's places in the map; empty: none.
};

// Says what became of every robot, and returns the exit code. `anchored` has those with fixes.
int ReportPush(const std::vector<PushSummary>& summaries, const std::vector<GnssSummary>& anchored,
               const PushReportOptions& options);

// Says where a robot was found, writes its poses, and returns the exit code.
int ReportPlaces(const LocaliseSummary& summary, const PushReportOptions& options);

}  // namespace isthmus::cli
