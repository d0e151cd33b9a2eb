// The contents of a recording, found by reading it.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "client/console/json.h"
#include "client/readers/recording.h"

namespace isthmus::cli {

struct TopicReport {
  readers::ScanTopic topic;
  std::string error;   // Why nothing of it can be read; else empty.
  std::string sensor;  // As far as it tells.
  std::string rings;   // "16, field 'ring'"; "none in the points".
  std::string times;   // "field 'time' (s, before the end of the scan)"; "none in the points".
  std::string fields;  // "x y z float32, intensity float32, ring uint16"
  uint64_t scans = 0, errors = 0, points = 0;
  std::string first_error;
  bool is_complete = true;  // Read to its end.
  int64_t first_ns = 0, last_ns = 0;
  double duration_s = 0;  // From the first to the last, whatever their clock was set to.
  double interval_s = 0;  // Median from scan to scan; 0: unknown.
  // Intervals of more than half as much again, and the longest.
  uint64_t gaps = 0;
  double longest_gap_s = 0;
  std::vector<std::string> assumptions;
};

struct RecordingReport {
  std::string path, kind;
  std::vector<std::string> notes;
  std::vector<TopicReport> topics;
  std::vector<readers::GnssTopic> gnss;
  std::vector<readers::StaticTransform> transforms;
  std::string command;  // Pushes the recording; empty if nothing can be read.
};

// Reads every topic, `most_scans` of each at most; `seen` is called after every scan.
absl::StatusOr<RecordingReport> ReadReport(const std::string& path,
                                           const readers::ReadOptions& options, uint64_t most_scans,
                                           const std::function<void()>& seen);

void PrintText(const RecordingReport& report);
Json ToJson(const RecordingReport& report);

}  // namespace isthmus::cli
