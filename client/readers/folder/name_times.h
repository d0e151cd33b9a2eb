// Times in the names of files.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "client/readers/folder/name_series.h"

namespace isthmus::readers {

struct NameTimes {
  std::vector<int64_t> stamps_ns;  // One for each name of the series, ascending.
  std::string reading;             // ", taken for UTC": behind "names of the files". May be empty.
};

// The times that the names of a series tell, which is put into their order. Numbers are times where
// the whole series can be read so, each name later than another by no less than a LiDAR takes. The
// first of these that holds:
//   Unix times   of 2001 to 2115: seconds (10 digits) with a fraction, or with 6 to 9 digits
//                behind "_" or "-"; milli-, micro- or nanoseconds (13, 16, 19 digits)
//   dates        year to second, as 2021-10-26-16-21-29-468 or 20211026_162129, taken for UTC
//   any seconds  with a fraction, of a simulation's clock
//   whole numbers that go up by what nano- or microseconds between scans are
// A fraction of always the same width is one. Of varying width, it is either a decimal fraction
// without zeros at its end, or ROS 2's nanoseconds without zeros before it (.61100006 is
// 0.061100006 s): zeros at either end tell, else the reading with the more even intervals.
std::optional<NameTimes> OrderByTimes(NameSeries& series);

}  // namespace isthmus::readers
