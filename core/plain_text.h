// Text that others wrote, made fit for a line of a log or a terminal.
#pragma once

#include <absl/strings/string_view.h>

#include <cstddef>
#include <string>

namespace isthmus {

// At most so many bytes, without half a character at their end (UTF-8).
std::string CutText(absl::string_view text, size_t most);

// Secrets of tokens begin so, by which one is known where it lies about.
inline constexpr char kSecretPrefix[] = "isthmus_";
// In place of each secret of a token, "isthmus_...".
std::string WithoutSecrets(absl::string_view text);

// The text with all that a terminal obeys as \xNN, control characters and line ends above all; of
// more than so many bytes the first, and "...". Without secrets.
std::string LineOf(absl::string_view text, size_t most);

bool IsUtf8(absl::string_view text);

// Bytes that are not UTF-8 become '?', one by one: messages carry nothing but UTF-8.
std::string ValidUtf8(absl::string_view text);

}  // namespace isthmus
