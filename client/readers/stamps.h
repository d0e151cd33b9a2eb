// The END of scans, of which drivers stamp now this instant and now that.
#pragma once

#include <absl/strings/string_view.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "client/readers/recording.h"
#include "core/codec/point_times.h"
#include "core/point_payload.h"

namespace isthmus::readers {

// The stamps of velodyne_pointcloud, ouster_ros, the drivers of Hesai, RoboSense and Livox, and
// recordings made for LIO-SAM, as they write their messages:
//   times of points from 0 up       the header's stamp is the START
//   times of points up to 0         the header's stamp is the END
//   times that are all 0            the header's stamp is that of the whole scan, which is
//                                   motion-compensated
//   times of a clock                they tell; the header's stamp only which clock it is
//   no times                        the header's stamp is taken for the END
// Units, counters that start again, and scans that miss a part of the turn are as in
// codec::TimeReader, which reads the times: the END is that of the latest return, and in scans
// that miss a part of the turn where it was in whole ones. So the END given here is what
// codec::ScanDecoder takes it for.
//
// Without a header's stamp (0, or beyond kLatestStampNs) the points' clock tells where it is that
// of Unix time, or its distance from the headers' is known; else the time of recording is taken for
// the END. A clock that counts nanoseconds in 32 bits, or those of the second, starts again every
// 4.3 s or 1 s: the headers tell how often it did, if they are late by less than half of that.
//
// Where headers stand still while other points are recorded later, or have whole seconds, the times
// of recording tell from there on how much later each scan ended than the first of them.
//
// Scans are not put in order, and none is left out: what comes too late or twice, and what of a
// clock that was set back, ScanClock tells wherever scans are used.
//
// Of one topic's scans, in their order. Not thread safe.
class ScanStamps {
 public:
  ScanStamps(StampMeaning meaning, double rate_hz) : meaning_(meaning), rate_hz_(rate_hz) {}

  // The END of a scan, nanoseconds since the Unix epoch, from its header's stamp and the time of
  // recording. The payload is raw and its layout was checked.
  int64_t End(const PointPayload& payload, int64_t header_ns, int64_t log_ns);
  // The same of a scan that nothing stamps, by its points' clock; empty where that is not of Unix
  // time.
  std::optional<int64_t> ByOwnClock(const PointPayload& payload);

  // As ScanReader's.
  std::vector<std::string> Assumptions() const { return assumptions_; }

 private:
  int64_t Guess(const PointPayload& payload, int64_t header_ns, int64_t log_ns);
  // The END by the times of the points, in seconds of their zero; empty without such.
  struct Times {
    double first_s = 0, end_s = 0;
    codec::TimeReader::Zero zero = codec::TimeReader::Zero::kStart;
    bool counts_ns = false;  // In 32 bits.
  };
  std::optional<Times> ReadTimes(const PointPayload& payload, int64_t header_ns);
  int64_t ByClock(const Times& times, int64_t header_ns);
  int64_t ByCounter(int64_t counter_end_ns, int64_t header_ns);
  int64_t WithoutHeader(const PointPayload& payload, int64_t log_ns);
  // A message as it came; `points` tells its points from others.
  struct Arrival {
    int64_t header_ns = 0, log_ns = 0;
    size_t points = 0;
  };
  // Sets log_offset_ns_ where the headers have begun to stand still.
  void LookForStandstill(const Arrival& now, int64_t end_ns);
  void Assume(absl::string_view sentence);

  const StampMeaning meaning_;
  const double rate_hz_;
  codec::TimeReader reader_;
  std::optional<Times> last_times_;          // The last scan's with times; a clock's end at 0.
  std::optional<int64_t> clock_offset_ns_;   // From the points' clock to the headers'.
  int64_t counter_turn_ns_ = 1'000'000'000;  // A counter starts again after it.
  std::optional<int64_t> last_end_ns_;
  std::optional<Arrival> last_arrival_;
  std::optional<int64_t> log_offset_ns_;  // From times of recording to the END; see above.
  std::vector<std::string> assumptions_;
};

}  // namespace isthmus::readers
