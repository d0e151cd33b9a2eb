// The unit and the zero of a scan's time field, which drivers leave to guesswork.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/point_payload.h"

namespace isthmus::codec {

// Seconds per unit of a time field whose values within one scan span `span` units; 0 when no unit
// makes sense. See DecodeScan for the rule.
double SecondsPerUnit(ScalarType type, double span);

// False for the largest uint32, which drivers write for a point without a time.
bool IsTime(ScalarType type, double value);

// Reads the times of one sensor's scans, one after the other. It remembers what a whole turn looks
// like, so that a scan of which the sensor saw only a part (a hand before it) keeps its unit and
// its END. Not thread safe.
class TimeReader {
 public:
  // Turns raw times of the returns into seconds relative to the END of the scan. What is no time
  // (IsTime) becomes that of the return before it, else of the first after it. False, and `times`
  // unspecified, when a time is not finite or no unit makes sense.
  bool Read(ScalarType type, int64_t end_stamp_ns, std::vector<double>& times);

  // A description of the last times that were understood: "ns, from the start of the scan".
  std::string Description() const;

  enum class Zero : uint8_t { kStart, kEnd, kClock };
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
  double EndOf(double first_s, double last_s, double stamp_s);
  Zero ZeroOfTurn(double first_s, double last_s);

  // As Memory's.
  double unit_s_ = 0, turn_s_ = 0, end_s_ = 0;
  Zero zero_ = Zero::kStart;
  int from_zero_ = 0;  // Whole turns in a row that begin at 0.
};

}  // namespace isthmus::codec
