#include "client/console/age.h"

#include <absl/strings/numbers.h>

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

}  // namespace isthmus::cli
