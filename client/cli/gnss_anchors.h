// Anchors of pushed robots, by the fixes in their recordings.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <cstdint>
#include <string>
#include <vector>

#include "client/console/recording_options.h"
#include "client/georeference/anchors_of_fixes.h"
#include "client/library/client.h"
#include "client/readers/recording.h"

namespace isthmus::cli {

// A robot's fixes, and where its antenna is.
struct GnssOfRobot {
  std::string robot, topic;
  std::vector<readers::GnssFix> fixes;  // At least one.
  georeference::Antenna antenna;
};

// The fixes of `wanted`, each TOPIC or, of several robots, TOPIC=ROBOT. NotFound, naming the topics
// there are, for another; InvalidArgument for a robot that is not pushed, or has two.
absl::StatusOr<std::vector<GnssOfRobot>> ReadGnss(const readers::Recording& recording,
                                                  const std::vector<std::string>& wanted,
                                                  const std::vector<RobotScans>& robots);

struct GnssSummary {
  std::string robot, topic;
  uint64_t fixes = 0;
  int submaps = 0, anchored = 0;
  int wild = 0;  // Submaps whose fix is far from where the way leads.
  bool is_new_datum = false;
  Datum datum;
};

// Anchors the submaps of a session, segments included, by what the robot's receiver measured; sets
// the datum, the first fix, where the site has none. Errors of AnchorsOfFixes and the server's.
absl::StatusOr<GnssSummary> AnchorByFixes(client::Client& client, const GnssOfRobot& gnss,
                                          const SessionId& session);

}  // namespace isthmus::cli
