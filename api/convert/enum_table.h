// Enumerations of ours and of the API, value by value: one table for both ways.
#pragma once

#include <cstddef>
#include <utility>

namespace isthmus::convert {

template <typename Ours, typename Theirs, size_t n>
constexpr Theirs ToMessage(const std::pair<Ours, Theirs> (&table)[n], Ours wanted) {
  for (const auto& [ours, theirs] : table) {
    if (ours == wanted) return theirs;
  }
  return Theirs{};  // Unspecified.
}

// `unknown` for a number that is not in the table, as a newer server or client may send.
template <typename Ours, typename Theirs, size_t n, typename Unknown>
constexpr Unknown FromMessage(const std::pair<Ours, Theirs> (&table)[n], Theirs wanted,
                              Unknown unknown) {
  for (const auto& [ours, theirs] : table) {
    if (theirs == wanted) return ours;
  }
  return unknown;
}

}  // namespace isthmus::convert
