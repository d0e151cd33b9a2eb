// A series of numbered files: which names belong to it, and in which order.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace isthmus::readers {

// A number in a name: "1600000000.61100006" has a fraction, "000012" has none.
struct NameNumber {
  std::string digits, fraction;
};

// A name, cut into its numbers and the texts around them, in lower case: "scan_7.pcd" has the texts
// "scan_" and ".pcd". There is one text more than there are numbers.
struct NameParts {
  std::vector<std::string> texts;
  std::vector<NameNumber> numbers;
};
NameParts CutName(const std::string& name);

struct NameSeries {
  std::vector<size_t> order;     // Indices of the names that belong to the series, in order.
  std::vector<size_t> left_out;  // Indices of the other names.
  // "scan_#.pcd", a # for each number; empty where names make no one series, and all are in order.
  std::string pattern;
  // The parts of the names in order; empty unless all have the pattern.
  std::vector<NameParts> parts;

  // Steps from the first name to each where the numbers count steadily: they have one step, from
  // which few are missing. Else empty.
  std::vector<int64_t> Steps() const;
  // The number of each name, where one number tells them apart and has no fraction. Else empty.
  std::vector<int64_t> Counts() const;
};

// The names that most have in common but for their numbers are the series; hidden files never are.
// It is in order of its numbers, the first that differs before all, whatever zeros they begin with.
// All names stay where no texts are those of more than half of them, in order of their texts and
// numbers.
NameSeries FindSeries(const std::vector<std::string>& names);

}  // namespace isthmus::readers
