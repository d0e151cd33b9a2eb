#include "client/readers/folder/times_file.h"

#include <absl/strings/ascii.h>
#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_split.h>
#include <absl/time/time.h>

#include <cmath>
#include <optional>

#include "client/readers/limits.h"

namespace isthmus::readers {
namespace {

// A double holds today's Unix time only to some 200 ns: whole seconds and the fraction are read
// apart.
std::optional<int64_t> ParseStamp(absl::string_view text) {
  absl::Time date;
  std::string error;
  if (text.size() > 10 && text[4] == '-' &&
      absl::ParseTime("%Y-%m-%d %H:%M:%E*S", text, &date, &error)) {
    const int64_t ns = absl::ToUnixNanos(date);
    return std::abs(ns) <= kLatestStampNs ? std::optional(ns) : std::nullopt;
  }
  double value = 0;
  if (!absl::SimpleAtod(text, &value) || !std::isfinite(value) ||
      std::abs(value) > 1e-9 * kLatestStampNs) {
    return std::nullopt;
  }
  const size_t dot = text.find('.');
  int64_t seconds = 0;
  const bool plain = value >= 0 && dot != absl::string_view::npos && dot > 0 &&
                     text.find_first_of("eE") == absl::string_view::npos &&
                     absl::SimpleAtoi(text.substr(0, dot), &seconds);
  if (!plain) return static_cast<int64_t>(std::llround(value * 1e9));
  std::string fraction(text.substr(dot + 1));
  fraction.resize(9, '0');
  int64_t ns = 0;
  if (!absl::SimpleAtoi(fraction, &ns)) return std::nullopt;
  return seconds * 1'000'000'000 + ns;
}

}  // namespace

absl::StatusOr<std::vector<int64_t>> ParseTimes(const std::string& text) {
  std::vector<int64_t> stamps;
  int line_number = 0;
  for (absl::string_view line : absl::StrSplit(text, '\n')) {
    ++line_number;
    line = absl::StripAsciiWhitespace(line);
    if (line.empty()) continue;
    const std::optional<int64_t> stamp = ParseStamp(line);
    if (!stamp) {
      return absl::InvalidArgumentError(
          absl::StrCat("line ", line_number, " is not a time in seconds: '", line, "'"));
    }
    stamps.push_back(*stamp);
  }
  return stamps;
}

}  // namespace isthmus::readers
