// Spans and points of time as a person types them.
#pragma once

#include <absl/time/time.h>

#include <optional>
#include <string>

namespace isthmus::cli {

// "30s", "45m", "12h", "30d", "2w"; nothing for anything else.
std::optional<absl::Duration> ParseAge(const std::string& text);
// Such a span back from now, a day ("2026-05-01", UTC) or a time ("2026-05-01T12:00:00Z"); nothing
// for anything else.
std::optional<absl::Time> ParseMoment(const std::string& text);

}  // namespace isthmus::cli
