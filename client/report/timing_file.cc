#include "client/report/timing_file.h"

#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_split.h>
#include <absl/strings/strip.h>

#include <cmath>
#include <filesystem>

#include "core/io/file_io.h"

namespace isthmus::report {
namespace {

absl::Status BadTiming(const std::string& path, size_t line, const std::string& why) {
  return absl::InvalidArgumentError(absl::StrCat(
      path, ", line ", line, ": ", why, "; expected: a file of isthmus odometry --timing"));
}

// The targets of a row's columns.
struct Columns {
  explicit Columns(std::vector<std::string> header, TimingFile* file)
      : names(std::move(header)), timing(file) {
    for (const std::string& column : names) {
      absl::string_view stage = column;
      const bool is_stage = absl::ConsumeSuffix(&stage, "_ms") && stage != "total";
      stage_of.push_back(is_stage ? static_cast<int>(timing->stages.size()) : -1);
      if (is_stage) timing->stages.push_back({std::string(stage), {}});
    }
  }

  // Empty, or why not.
  std::string Add(const std::vector<std::string>& cells) {
    if (cells.size() != names.size()) {
      return absl::StrCat(cells.size(), " cells below ", names.size(), " columns");
    }
    double sum = 0;
    auto scan = static_cast<double>(timing->scans.size()), total = -1.0;
    std::string tracking;
    for (size_t i = 0; i < cells.size(); ++i) {
      if (names[i] == "tracking") tracking = cells[i];
      const bool is_total = names[i] == "total_ms";
      if (stage_of[i] < 0 && !is_total && names[i] != "scan") continue;
      double value = 0;
      if (!absl::SimpleAtod(cells[i], &value) || !std::isfinite(value)) {
        return absl::StrCat("'", cells[i], "' is not a number");
      }
      if (stage_of[i] >= 0) {
        timing->stages[static_cast<size_t>(stage_of[i])].ms.push_back(value);
        sum += value;
      } else {
        (is_total ? total : scan) = value;
      }
    }
    timing->scans.push_back(scan);
    timing->total_ms.push_back(total >= 0 ? total : sum);
    timing->tracking.push_back(tracking);
    return "";
  }

  std::vector<std::string> names;
  std::vector<int> stage_of;  // -1: no stage.
  TimingFile* timing;
};

}  // namespace

absl::StatusOr<TimingFile> ReadTimingFile(const std::string& path) {
  const auto text = io::ReadFile(path);
  if (!text.ok()) return text.status();
  TimingFile file;
  file.name = std::filesystem::path(path).stem();
  const std::vector<std::string> lines = absl::StrSplit(*text, '\n');
  Columns columns(absl::StrSplit(absl::StripSuffix(lines[0], "\r"), ','), &file);
  if (file.stages.empty()) return BadTiming(path, 1, "no column is called ..._ms");
  for (size_t i = 1; i < lines.size(); ++i) {
    const absl::string_view line = absl::StripSuffix(lines[i], "\r");
    if (line.empty()) continue;
    const std::string problem = columns.Add(absl::StrSplit(line, ','));
    if (!problem.empty()) return BadTiming(path, i + 1, problem);
  }
  if (file.scans.empty()) return BadTiming(path, 2, "no scan was timed");
  return file;
}

}  // namespace isthmus::report
