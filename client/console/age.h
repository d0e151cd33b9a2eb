// Spans of time as a person types them.
#pragma once

#include <absl/time/time.h>

#include <optional>
#include <string>

namespace isthmus::cli {

// "30s", "45m", "12h", "30d", "2w"; nothing for anything else.
std::optional<absl::Duration> ParseAge(const std::string& text);

}  // namespace isthmus::cli
