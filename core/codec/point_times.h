// The unit and the zero of a scan's time field, which drivers leave to guesswork.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/point_payload.h"

namespace isthmus::codec {

// True for the time that one turn of a LiDAR takes.
bool IsTurn(double seconds);

// Reads the times of one sensor's scans, one after the other. It remembers what a whole turn looks
// like, so that a scan of which the sensor saw only a part (a hand before it) keeps its unit and
// its END. Not thread safe.
class TimeReader {
 public:
  // Turns raw times of the returns into seconds relative to the END of the scan. The largest
  // uint32, which drivers write for a point without a time, becomes that of the return before it,
  // else of the first after it. The times are those of most points, two thirds at least, that lie
  // in one turn: any other, and one that is not finite, is odd and becomes NaN. `unit_s`: seconds
  // per unit, where that is known; else 0. False, and `times` unspecified, where no unit makes
  // sense.
  bool Read(ScalarType type, int64_t end_stamp_ns, std::vector<double>& times, double unit_s = 0);

  // The last scan whose times were understood.
  struct Reading {
    double unit_s = 0;
    // The first return and the END, in seconds of the field's own zero.
    double first_s = 0, end_s = 0;
    size_t odd = 0;  // Times that are none.
  };
  const Reading& last() const { return last_; }

  // A description of the last times that were understood: "ns, from the start of the scan".
  std::string Description() const;

  // kInstant: all are 0, the scan is motion-compensated already.
  enum class Zero : uint8_t { kStart, kEnd, kClock, kInstant };
  // All that was learnt from the scans so far.
  struct Memory {
    double unit_s = 0;  // 0 before the first whole turn.
    double turn_s = 0;  // Time from the first to the last return of a whole turn.
    // The time, of whole turns, of the last return, or for clock times how far it is before the
    // stamp.
    double end_s = 0;
    Zero zero = Zero::kStart;
  };
  Memory memory() const { return {unit_s_, turn_s_, end_s_, zero_}; }
  // Goes on where another one stopped.
  void Restore(const Memory& memory);

 private:
  // The first and the last of some times.
  struct Range {
    double first = 0, last = 0;
    double span() const { return last - first; }
  };
  static Range RangeOf(const std::vector<double>& times);
  std::optional<Range> TakeBulk(double unit_s, double least_s, std::vector<double>& times);
  std::optional<Range> TakeMost(ScalarType type, double given_s, std::vector<double>& times,
                                double* unit);
  std::optional<Range> Understand(ScalarType type, double given_s, std::vector<double>& times,
                                  double* unit);
  double EndOf(double first_s, double last_s, double stamp_s);
  Zero ZeroOfTurn(double first_s, double last_s);

  // As Memory's.
  double unit_s_ = 0, turn_s_ = 0, end_s_ = 0;
  Zero zero_ = Zero::kStart;
  int from_zero_ = 0;  // Whole turns in a row that begin at 0.
  Reading last_;
  std::vector<double> sorted_;
};

}  // namespace isthmus::codec
