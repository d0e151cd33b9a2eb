// The place in a recording at which its recorder's clock was set back.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace isthmus::readers {

// The first and the last time of recording in a stretch of a file, nanoseconds.
struct LogSpan {
  int64_t first_ns = 0, last_ns = 0;
};

// True where what was recorded next is so much earlier that a clock may have been set back.
bool GoesBack(int64_t from_ns, int64_t to_ns);

struct ClockStep {
  size_t at = 0;           // The first stretch that holds messages from behind the step.
  bool is_within = false;  // It begins with others.
  double back_s = 0;
  // The clock was set: the order of the file is that of the messages. False where the parts follow
  // each other the other way round, as those of a recording that were joined in the wrong order.
  bool was_set = false;

  // A sentence for ScanReader::Assumptions.
  std::string Text() const;
};

// Recorders write as messages come, but for some that are late, so times that go back once, by more
// than kLeastStepBackS, are those of a clock that was set; times that do so again and again are
// those of a file that was put in another order, and give none. So do those of a recording that was
// joined with itself.
std::optional<ClockStep> FindClockStep(const std::vector<LogSpan>& in_file_order);

}  // namespace isthmus::readers
