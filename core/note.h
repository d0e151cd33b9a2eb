// The note that a person writes beside a decision.
#pragma once

#include <absl/status/status.h>
#include <absl/strings/str_cat.h>

#include <cstddef>
#include <string>

namespace isthmus {

inline constexpr size_t kMaxNote = 1000;  // Bytes.

// InvalidArgument for one that is longer.
inline absl::Status CheckNote(const std::string& note) {
  if (note.size() <= kMaxNote) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat("the note has ", note.size(), " characters; ", kMaxNote, " are kept"));
}

}  // namespace isthmus
