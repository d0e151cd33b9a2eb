#include "core/plain_text.h"

#include <absl/strings/ascii.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <algorithm>

namespace isthmus {
namespace {

// Bytes of the character that begins there, if it is one that a terminal obeys; else 0.
size_t ControlAt(absl::string_view text, size_t at) {
  const auto c = static_cast<unsigned char>(text[at]);
  if (c < 0x20 || c == 0x7F) return 1;
  // C1 controls are two bytes in UTF-8.
  const auto next = static_cast<unsigned char>(at + 1 < text.size() ? text[at + 1] : 0);
  if (c == 0xC2) return next >= 0x80 && next < 0xA0 ? 2 : 0;
  // Characters that turn the direction of a line: U+200E and F, U+2028 to E (ends of lines among
  // them), and U+2066 to 9, three bytes each.
  const auto last = static_cast<unsigned char>(at + 2 < text.size() ? text[at + 2] : 0);
  if (c != 0xE2) return 0;
  const bool turns =
      (next == 0x80 && (last == 0x8E || last == 0x8F || (last >= 0xA8 && last <= 0xAE))) ||
      (next == 0x81 && last >= 0xA6 && last <= 0xA9);
  return turns ? 3 : 0;
}

// Bytes of the character that begins there; 0: it is none. By
// https://www.rfc-editor.org/rfc/rfc3629.
size_t CharacterAt(absl::string_view text, size_t at) {
  const auto byte = [&](size_t k) {
    return at + k < text.size() ? static_cast<unsigned char>(text[at + k]) : 0u;
  };
  const unsigned first = byte(0);
  if (first < 0x80) return 1;
  const size_t length = first >= 0xC2 && first < 0xE0   ? 2
                        : first >= 0xE0 && first < 0xF0 ? 3
                        : first >= 0xF0 && first < 0xF5 ? 4
                                                        : 0;
  for (size_t k = 1; k < length; ++k) {
    if ((byte(k) & 0xC0) != 0x80) return 0;
  }
  // Longer than need be, half of a pair of UTF-16, or beyond what there is.
  const unsigned second = byte(1);
  const bool is_none = (first == 0xE0 && second < 0xA0) || (first == 0xED && second >= 0xA0) ||
                       (first == 0xF0 && second < 0x90) || (first == 0xF4 && second >= 0x90);
  return is_none ? 0 : length;
}

}  // namespace

std::string CutText(absl::string_view text, size_t most) {
  if (text.size() <= most) return std::string(text);
  while (most > 0 && (static_cast<unsigned char>(text[most]) & 0xC0) == 0x80) --most;
  return std::string(text.substr(0, most));
}

std::string WithoutSecrets(absl::string_view text) {
  constexpr size_t kLetters = 43;  // Layout: 32 bytes, by Base64.
  const auto is_letter = [](char c) {
    return absl::ascii_isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '-';
  };
  std::string rest;
  while (true) {
    const size_t at = text.find(kSecretPrefix);
    if (at == absl::string_view::npos) return absl::StrCat(rest, text);
    const size_t begin = at + sizeof(kSecretPrefix) - 1;
    size_t end = begin;
    while (end < text.size() && is_letter(text[end])) ++end;
    const bool is_secret = end - begin >= kLetters;
    absl::StrAppend(&rest, text.substr(0, begin), is_secret ? "..." : "");
    text.remove_prefix(is_secret ? end : begin);
  }
}

std::string LineOf(absl::string_view given, size_t most) {
  const std::string text = WithoutSecrets(given);
  std::string line;
  for (size_t i = 0; i < text.size();) {
    const size_t control = ControlAt(text, i);
    std::string piece;
    for (size_t k = 0; k < control; ++k) {
      absl::StrAppendFormat(&piece, "\\x%02x", static_cast<unsigned char>(text[i + k]));
    }
    if (control == 0) piece = text[i];
    if (line.size() + piece.size() > most) return line + "...";
    line += piece;
    i += std::max<size_t>(control, 1);
  }
  return line;
}

bool IsUtf8(absl::string_view text) {
  size_t at = 0;
  while (at < text.size()) {
    const size_t length = CharacterAt(text, at);
    if (length == 0) return false;
    at += length;
  }
  return true;
}

std::string ValidUtf8(absl::string_view text) {
  std::string valid;
  for (size_t i = 0; i < text.size();) {
    const size_t length = CharacterAt(text, i);
    if (length == 0) {
      valid += '?';
    } else {
      valid.append(text.data() + i, length);
    }
    i += length == 0 ? 1 : length;
  }
  return valid;
}

}  // namespace isthmus
