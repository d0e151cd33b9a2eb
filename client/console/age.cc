#include "client/console/age.h"

#include <absl/strings/numbers.h>
#include <absl/time/clock.h>

#include <cstdint>

namespace isthmus::cli {

std::optional<absl::Duration> ParseAge(const std::string& text) {
  if (text.empty()) return std::nullopt;
  int64_t count = 0;
  if (!absl::SimpleAtoi(text.substr(0, text.size() - 1), &count) || count <= 0 || count > 1000000) {
    return std::nullopt;
  }
  switch (text.back()) {
    case 's':
      return absl::Seconds(count);
    case 'm':
      return absl::Minutes(count);
    case 'h':
      return absl::Hours(count);
    case 'd':
      return absl::Hours(24 * count);
    case 'w':
      return absl::Hours(24 * 7 * count);
    default:
      return std::nullopt;
  }
}

std::optional<absl::Time> ParseMoment(const std::string& text) {
  if (const auto age = ParseAge(text)) return absl::Now() - *age;
  absl::Time time;
  if (absl::ParseTime(absl::RFC3339_full, text, &time, nullptr) ||
      absl::ParseTime("%Y-%m-%d", text, &time, nullptr)) {
    return time;
  }
  return std::nullopt;
}

}  // namespace isthmus::cli
