#include "client/readers/folder/name_series.h"

#include <absl/strings/ascii.h>
#include <absl/strings/numbers.h>
#include <absl/strings/str_join.h>
#include <absl/strings/strip.h>

#include <algorithm>
#include <compare>
#include <map>
#include <optional>
#include <utility>

#include "client/readers/limits.h"

namespace isthmus::readers {
namespace {

// Compares whole numbers of any length.
std::strong_ordering CompareDigits(absl::string_view a, absl::string_view b) {
  while (absl::ConsumePrefix(&a, "0")) {
  }
  while (absl::ConsumePrefix(&b, "0")) {
  }
  if (a.size() != b.size()) return a.size() <=> b.size();
  return a.compare(b) <=> 0;
}

bool IsBefore(const NameParts& a, const NameParts& b) {
  for (size_t i = 0; i < std::min(a.texts.size(), b.texts.size()); ++i) {
    if (const int order = a.texts[i].compare(b.texts[i]); order != 0) return order < 0;
    if (i >= a.numbers.size() || i >= b.numbers.size()) break;
    const NameNumber &x = a.numbers[i], &y = b.numbers[i];
    if (const auto order = CompareDigits(x.digits, y.digits); order != 0) return order < 0;
    if (const auto order = CompareDigits(x.fraction, y.fraction); order != 0) return order < 0;
  }
  return a.texts.size() < b.texts.size();
}

// The only number that is not the same in all of them; empty where there is none or several.
std::optional<size_t> OnlyVarying(const std::vector<NameParts>& parts) {
  std::optional<size_t> varying;
  for (size_t k = 0; k < parts.front().numbers.size(); ++k) {
    const NameNumber& first = parts.front().numbers[k];
    const bool varies = std::any_of(parts.begin(), parts.end(), [&](const NameParts& name) {
      return name.numbers[k].digits != first.digits || name.numbers[k].fraction != first.fraction;
    });
    if (varies && varying) return std::nullopt;
    if (varies) varying = k;
  }
  // A single name: its last number.
  if (parts.size() == 1 && !parts.front().numbers.empty()) return parts.front().numbers.size() - 1;
  return varying;
}

}  // namespace

NameParts CutName(const std::string& name) {
  NameParts parts{{""}, {}};
  const auto digits_from = [&](size_t at) {
    size_t end = at;
    while (end < name.size() && absl::ascii_isdigit(name[end])) ++end;
    return name.substr(at, end - at);
  };
  for (size_t i = 0; i < name.size();) {
    NameNumber number{digits_from(i), ""};
    if (number.digits.empty()) {
      parts.texts.back() += absl::ascii_tolower(name[i++]);
      continue;
    }
    i += number.digits.size();
    if (i < name.size() && name[i] == '.') number.fraction = digits_from(i + 1);
    if (!number.fraction.empty()) i += 1 + number.fraction.size();
    parts.numbers.push_back(std::move(number));
    parts.texts.emplace_back();
  }
  return parts;
}

std::vector<int64_t> NameSeries::Counts() const {
  if (parts.empty()) return {};
  const std::optional<size_t> k = OnlyVarying(parts);
  if (!k) return {};
  std::vector<int64_t> counts;
  for (const NameParts& name : parts) {
    const NameNumber& number = name.numbers[*k];
    if (!number.fraction.empty() || !absl::SimpleAtoi(number.digits, &counts.emplace_back())) {
      return {};
    }
  }
  return counts;
}

std::vector<int64_t> NameSeries::Steps() const {
  std::vector<int64_t> counts = Counts();
  if (counts.size() < 2) return counts.empty() ? counts : std::vector<int64_t>{0};
  std::vector<int64_t> steps;
  for (size_t i = 1; i < counts.size(); ++i) steps.push_back(counts[i] - counts[i - 1]);
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  const int64_t step = *middle;
  size_t regular = 0;
  for (const int64_t s : steps) {
    // Names that differ by their zeros alone have the same number.
    if (s <= 0 || s % step != 0) return {};
    regular += s == step ? 1 : 0;
  }
  if (static_cast<double>(regular) < kSteadyShare * static_cast<double>(steps.size())) return {};
  const int64_t first = counts.front();
  for (int64_t& count : counts) count = (count - first) / step;
  return counts;
}

NameSeries FindSeries(const std::vector<std::string>& names) {
  NameSeries series;
  std::vector<NameParts> parts(names.size());
  std::map<std::vector<std::string>, size_t> frequency;
  size_t visible = 0;
  for (size_t i = 0; i < names.size(); ++i) {
    if (names[i].front() == '.') continue;
    ++visible;
    parts[i] = CutName(names[i]);
    if (!parts[i].numbers.empty()) ++frequency[parts[i].texts];
  }
  const auto most =
      std::max_element(frequency.begin(), frequency.end(),
                       [](const auto& a, const auto& b) { return a.second < b.second; });
  const bool is_series = most != frequency.end() && 2 * most->second > visible;
  for (size_t i = 0; i < names.size(); ++i) {
    const bool belongs = names[i].front() != '.' && (!is_series || parts[i].texts == most->first);
    (belongs ? series.order : series.left_out).push_back(i);
  }
  std::sort(series.order.begin(), series.order.end(), [&](size_t a, size_t b) {
    if (IsBefore(parts[a], parts[b])) return true;
    return !IsBefore(parts[b], parts[a]) && names[a] < names[b];
  });
  if (!is_series) return series;
  series.pattern = absl::StrJoin(most->first, "#");
  for (const size_t i : series.order) series.parts.push_back(std::move(parts[i]));
  return series;
}

}  // namespace isthmus::readers
