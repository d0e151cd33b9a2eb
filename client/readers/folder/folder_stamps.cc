#include "client/readers/folder/folder_stamps.h"

#include <absl/strings/ascii.h>
#include <absl/strings/match.h>
#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "client/readers/folder/times_file.h"
#include "client/readers/limits.h"
#include "core/io/file_io.h"

namespace isthmus::readers {
namespace {

absl::StatusOr<std::vector<int64_t>> ReadTimes(const std::filesystem::path& file,
                                               const ScanFiles& scans) {
  const absl::StatusOr<std::string> text = io::ReadFile(file);
  if (!text.ok()) return text.status();
  absl::StatusOr<std::vector<int64_t>> stamps = ParseTimes(*text);
  if (!stamps.ok()) {
    return absl::InvalidArgumentError(absl::StrCat(file.string(), ": ", stamps.status().message()));
  }
  if (stamps->size() == scans.files.size()) return stamps;
  return absl::InvalidArgumentError(absl::StrCat(file.string(), " has ", stamps->size(),
                                                 " times for ", scans.files.size(), " scans in ",
                                                 scans.folder.string()));
}

bool IsDigits(const std::string& text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), absl::ascii_isdigit);
}

// Nanoseconds of the last digit, by the number of digits; 0: such a number only counts.
int64_t UnitOf(size_t digits) {
  switch (digits) {
    case 13:
      return 1'000'000;
    case 16:
      return 1'000;
    case 19:
      return 1;
    default:
      return 0;
  }
}

// A Unix time of 2001 to 2115 in a file's name; any other number only counts.
std::optional<int64_t> StampOfName(const std::string& stem) {
  const size_t dot = stem.find('.');
  std::string digits = stem.substr(0, dot);
  if (!IsDigits(digits)) return std::nullopt;
  if (dot != std::string::npos) {
    std::string fraction = stem.substr(dot + 1);
    if (digits.size() != 10 || !IsDigits(fraction)) return std::nullopt;
    fraction.resize(9, '0');
    digits += fraction;
  }
  const int64_t unit_ns = UnitOf(digits.size());
  int64_t value = 0;
  if (unit_ns == 0 || !absl::SimpleAtoi(digits, &value)) return std::nullopt;
  return value <= kLatestStampNs / unit_ns ? std::optional(value * unit_ns) : std::nullopt;
}

std::optional<std::vector<int64_t>> StampsOfNames(const ScanFiles& scans) {
  std::vector<int64_t> stamps;
  for (const std::filesystem::path& file : scans.files) {
    const std::optional<int64_t> stamp = StampOfName(file.stem().string());
    if (!stamp || (!stamps.empty() && *stamp <= stamps.back())) return std::nullopt;
    stamps.push_back(*stamp);
  }
  return stamps;
}

// Half the usual interval between scans.
int64_t HalfTurn(const std::vector<int64_t>& stamps, double rate_hz) {
  std::vector<int64_t> intervals;
  for (size_t i = 1; i < stamps.size(); ++i) intervals.push_back(stamps[i] - stamps[i - 1]);
  if (intervals.empty()) return std::llround(0.5e9 / rate_hz);
  std::nth_element(intervals.begin(), intervals.begin() + intervals.size() / 2, intervals.end());
  return intervals[intervals.size() / 2] / 2;
}

}  // namespace

absl::StatusOr<FolderStamps> StampsOf(const ScanFiles& files, double rate_hz) {
  if (!(rate_hz > 0) || !std::isfinite(rate_hz)) {
    return absl::InvalidArgumentError("the rate must be positive");
  }
  for (const char* name : {"times.txt", "timestamps_end.txt", "timestamps.txt"}) {
    const std::optional<std::filesystem::path> file = FindBeside(files.folder, name);
    if (!file || files.is_one_file) continue;
    absl::StatusOr<std::vector<int64_t>> times = ReadTimes(*file, files);
    if (!times.ok()) return times.status();
    FolderStamps stamps{*std::move(times), false, false,
                        absl::StrCat("stamps are those of ", file->string(), ", the END of scans")};
    if (!absl::StartsWith(file->filename().string(), "timestamps.")) return stamps;
    const int64_t half_ns = HalfTurn(stamps.stamps_ns, rate_hz);
    for (int64_t& stamp : stamps.stamps_ns) stamp += half_ns;
    stamps.origin = absl::StrCat("scans ended half a turn after the times in ", file->string());
    return stamps;
  }
  if (std::optional<std::vector<int64_t>> names = StampsOfNames(files)) {
    return FolderStamps{*std::move(names), true, false, "stamps are the names of the files"};
  }
  FolderStamps stamps;
  for (size_t i = 0; i < files.files.size(); ++i) {
    stamps.stamps_ns.push_back(std::llround(static_cast<double>(i) * 1e9 / rate_hz));
  }
  stamps.only_count = true;
  stamps.origin = absl::StrCat("scan i ended at i / ", rate_hz,
                               " seconds: there is no times.txt, and names are no times");
  return stamps;
}

}  // namespace isthmus::readers
