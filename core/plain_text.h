// Text that others wrote, made fit for a line of a log or a terminal.
#pragma once

#include <absl/strings/string_view.h>

#include <cstddef>
#include <string>

namespace isthmus {

// At most so many bytes, without half a character at their end (UTF-8).
std::string CutText(absl::string_view text, size_t most);

// What a terminal obeys as \xNN, control characters and line ends above all; of more than so many
// bytes the first, and "...".
std::string LineOf(absl::string_view text, size_t most);

// What is not UTF-8 becomes '?', byte by byte: messages carry nothing else.
std::string ValidUtf8(absl::string_view text);

}  // namespace isthmus
