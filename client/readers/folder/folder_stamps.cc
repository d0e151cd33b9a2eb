#include "client/readers/folder/folder_stamps.h"

#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <utility>

#include "client/readers/folder/times_file.h"
#include "client/readers/limits.h"
#include "core/formats/kitti_poses.h"
#include "core/io/file_io.h"

namespace isthmus::readers {
namespace {

// The trajectory that times belong to: KITTI's rows beside them, as many. Empty where there is
// none.
std::string TrajectoryOf(const std::filesystem::path& times, size_t count) {
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(times.parent_path(), error)) {
    std::error_code ignored;
    const bool may_be =
        entry.is_regular_file(ignored) && entry.file_size(ignored) / kMostPoseLine <= count;
    if (!may_be) continue;
    const absl::StatusOr<std::string> text = io::ReadFile(entry.path());
    if (!text.ok() || !formats::LooksLikeKittiPoses(*text)) continue;
    const auto poses = formats::ParseKittiPoses(*text);
    if (poses.ok() && poses->size() == count) return entry.path().string();
  }
  return "";
}

// The times of the scans, where the file has those of them all, or of all numbers of their series.
std::optional<std::vector<int64_t>> TimesFor(const ScanFiles& scans, std::vector<int64_t> times) {
  if (times.size() == scans.files.size()) return times;
  const std::vector<int64_t> counts = scans.series.Counts(), steps = scans.series.Steps();
  const bool numbered = !steps.empty() && counts.back() == static_cast<int64_t>(times.size()) - 1 &&
                        counts.front() == 0 && steps.back() == counts.back();
  if (!numbered) return std::nullopt;
  std::vector<int64_t> chosen;
  for (const int64_t count : counts) chosen.push_back(times[static_cast<size_t>(count)]);
  return chosen;
}

// Empty, and a sentence in `notes`, for times that are a trajectory's.
absl::StatusOr<std::optional<std::vector<int64_t>>> ReadTimes(const std::filesystem::path& file,
                                                              const ScanFiles& scans,
                                                              std::vector<std::string>& notes) {
  const absl::StatusOr<std::string> text = io::ReadFile(file);
  if (!text.ok()) return text.status();
  absl::StatusOr<std::vector<int64_t>> stamps = ParseTimes(*text);
  if (!stamps.ok()) {
    return absl::InvalidArgumentError(absl::StrCat(file.string(), ": ", stamps.status().message()));
  }
  const size_t count = stamps->size();
  std::optional<std::vector<int64_t>> times = TimesFor(scans, *std::move(stamps));
  if (times) return times;
  const std::string numbers = absl::StrCat(file.string(), " has ", count, " times for ",
                                           scans.files.size(), " scans in ", scans.folder.string());
  const std::string trajectory = TrajectoryOf(file, count);
  if (trajectory.empty()) return absl::InvalidArgumentError(numbers);
  notes.push_back(absl::StrCat(numbers, ": they are those of ", trajectory, ", and not used"));
  return std::nullopt;
}

// Half the usual interval between scans.
int64_t HalfTurn(const std::vector<int64_t>& stamps, double rate_hz) {
  std::vector<int64_t> intervals;
  for (size_t i = 1; i < stamps.size(); ++i) intervals.push_back(stamps[i] - stamps[i - 1]);
  if (intervals.empty()) return std::llround(0.5e9 / rate_hz);
  std::nth_element(intervals.begin(), intervals.begin() + intervals.size() / 2, intervals.end());
  return intervals[intervals.size() / 2] / 2;
}

// The scans that are missing are the gaps between steps.
FolderStamps Count(const ScanFiles& scans, double rate_hz) {
  FolderStamps stamps;
  stamps.only_count = true;
  stamps.origin = {absl::StrCat("scan i ended at i / ", rate_hz,
                                " seconds: there is no times.txt, and the names are not times")};
  std::vector<int64_t> steps = scans.series.Steps();
  if (!steps.empty() && static_cast<double>(steps.back()) / rate_hz > 1e-9 * kLatestStampNs) {
    steps.clear();
  }
  for (size_t i = 0; i < scans.files.size(); ++i) {
    const double step = static_cast<double>(steps.empty() ? static_cast<int64_t>(i) : steps[i]);
    stamps.stamps_ns.push_back(std::llround(step * 1e9 / rate_hz));
    const int64_t missing = i > 0 && !steps.empty() ? steps[i] - steps[i - 1] - 1 : 0;
    if (missing == 0 || stamps.origin.size() > 1) continue;
    stamps.origin.push_back(absl::StrCat(steps.back() + 1 - static_cast<int64_t>(steps.size()),
                                         " numbers are missing from the names, the first before ",
                                         scans.files[i].filename().string(),
                                         ": these are taken for gaps in time"));
  }
  return stamps;
}

FolderStamps StampsOfNames(const ScanFiles& scans, double rate_hz) {
  if (!scans.times) return Count(scans, rate_hz);
  return FolderStamps{scans.times->stamps_ns,
                      true,
                      false,
                      {absl::StrCat("stamps are the names of the files", scans.times->reading)}};
}

}  // namespace

absl::StatusOr<FolderStamps> StampsOf(const ScanFiles& files, double rate_hz) {
  if (!(rate_hz > 0) || !std::isfinite(rate_hz)) {
    return absl::InvalidArgumentError("the rate must be positive");
  }
  std::vector<std::string> notes;
  for (const char* name : {"times.txt", "timestamps_end.txt", "timestamps.txt"}) {
    const std::optional<std::filesystem::path> file = FindBeside(files.folder, name);
    if (!file || files.is_one_file) continue;
    auto times = ReadTimes(*file, files, notes);
    if (!times.ok()) return times.status();
    if (!times->has_value()) continue;
    FolderStamps stamps{**std::move(times), false, false, std::move(notes)};
    const bool forwards = absl::StartsWith(file->filename().string(), "timestamps.");
    stamps.origin.push_back(
        forwards ? absl::StrCat("scans ended half a turn after the times in ", file->string())
                 : absl::StrCat("stamps are those of ", file->string(), ", the END of scans"));
    if (!forwards) return stamps;
    const int64_t half_ns = HalfTurn(stamps.stamps_ns, rate_hz);
    for (int64_t& stamp : stamps.stamps_ns) stamp += half_ns;
    return stamps;
  }
  FolderStamps stamps = StampsOfNames(files, rate_hz);
  stamps.origin.insert(stamps.origin.begin(), notes.begin(), notes.end());
  return stamps;
}

}  // namespace isthmus::readers
