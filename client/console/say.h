// Lines for a person at a terminal, whoever wrote what is in them.
#pragma once

#include <absl/strings/str_format.h>
#include <absl/strings/string_view.h>

#include <cstdio>
#include <string>
#include <type_traits>
#include <utility>

namespace isthmus::cli {

// Names, notes and messages come from servers and files: without what a terminal obeys, ends of
// lines included, and without secrets of tokens.
std::string Printable(absl::string_view text);
// Printable text, but with its own ends of lines, which must be ours: others' text in it has gone
// through Printable. Longer lines keep their first `longest_line` bytes.
std::string Lines(absl::string_view text, size_t longest_line = absl::string_view::npos);

// An argument of a line: text as Printable has it, anything else as it is.
template <typename T>
decltype(auto) Said(const T& value) {
  if constexpr (std::is_convertible_v<const T&, absl::string_view>) {
    return Printable(value);
  } else {
    return (value);
  }
}
template <typename T>
using SaidAs = std::decay_t<decltype(Said(std::declval<const T&>()))>;

// As absl::StrFormat, absl::PrintF to stdout and to stderr, but with arguments as Said has them.
template <typename... Args>
std::string LineText(const absl::FormatSpec<SaidAs<Args>...>& format, const Args&... args) {
  return absl::StrFormat(format, Said(args)...);
}
template <typename... Args>
void Say(const absl::FormatSpec<SaidAs<Args>...>& format, const Args&... args) {
  absl::PrintF(format, Said(args)...);
}
template <typename... Args>
void Warn(const absl::FormatSpec<SaidAs<Args>...>& format, const Args&... args) {
  absl::FPrintF(stderr, format, Said(args)...);
}
// To stdout, as Lines has it.
void SayLines(absl::string_view text);

}  // namespace isthmus::cli
