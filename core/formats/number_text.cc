#include "core/formats/number_text.h"

#include <absl/strings/match.h>
#include <absl/strings/numbers.h>

#include <charconv>
#include <cmath>
#include <limits>
#include <type_traits>

#include "core/codec/column.h"

namespace isthmus::formats {
namespace {

template <typename T>
bool ParseAs(absl::string_view word, T& value) {
  const char* const end = word.data() + word.size();
  const auto parsed = std::from_chars(word.data(), end, value);
  return parsed.ec == std::errc() && parsed.ptr == end;
}

absl::string_view WithoutPlus(absl::string_view word) {
  return word.size() > 1 && word[0] == '+' && word[1] != '-' ? word.substr(1) : word;
}

// Makes a T of a number that is not written as one of its kind.
template <typename T>
std::optional<T> Convert(absl::string_view word) {
  const std::optional<double> value = ParseNumber(word);
  constexpr double kMost = static_cast<double>(std::numeric_limits<T>::max());
  if (!value) return std::nullopt;
  if constexpr (std::is_integral_v<T>) {
    if (!(*value >= static_cast<double>(std::numeric_limits<T>::min()) && *value <= kMost)) {
      return std::nullopt;
    }
  } else if (std::abs(*value) > kMost && std::isfinite(*value)) {
    return std::nullopt;
  }
  return static_cast<T>(*value);
}

}  // namespace

std::optional<double> ParseNumber(absl::string_view word) {
  word = WithoutPlus(word);
  double value = 0;
  if (ParseAs(word, value)) return value;
  // Numbers out of range look like any other word to from_chars; only tiny ones have a value.
  const bool is_number = word.find_first_of("eE") != absl::string_view::npos &&
                         absl::SimpleAtod(word, &value) && std::isfinite(value) &&
                         std::abs(value) < 1;
  return is_number ? std::optional(value) : std::nullopt;
}

bool StoreNumber(absl::string_view word, ScalarType type, char* out) {
  return codec::VisitScalar(type, [&](auto none) {
    using T = decltype(none);
    if constexpr (std::is_floating_point_v<T>) none = std::numeric_limits<T>::quiet_NaN();
    T value{};
    bool is_read = ParseAs(WithoutPlus(word), value);
    if (!is_read) {
      const std::optional<T> converted = Convert<T>(word);
      is_read = converted.has_value();
      value = converted.value_or(none);
    }
    codec::StoreAs(value, out);
    return is_read;
  });
}

}  // namespace isthmus::formats
