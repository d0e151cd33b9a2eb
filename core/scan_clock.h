// The stamps of a robot's scans as a time that only goes forward.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>

namespace isthmus {

// Robots' clocks step: they are set once the network is up, or an hour back by mistake. Not thread
// safe.
//
// A stamp that is not later than the last one is a scan out of order, or sent twice, and refused.
// If the next one is not later either, but goes on from the refused one, the clock was set back,
// by however much: that scan is the next but one. A clock set forward cannot be told from a robot
// that paused: that is a gap, after which the odometry searches. Either way the time between the
// two scans is not known.
class ScanClock {
 public:
  // A pause of a minute or of a year is the same to the odometry: no step is longer.
  static constexpr int64_t kMaxStep_ns = 10'000'000'000;
  // Scans this far apart still give the interval by which a clock that was set goes on; longer ones
  // are pauses. Spinning sensors take 50 to 200 ms.
  static constexpr int64_t kMaxInterval_ns = 600'000'000;

  struct Reading {
    int64_t time_ns = 0;   // Later than that of the scan before it, by 10 s at most.
    bool stepped = false;  // The clock was set back, or was set forward or paused.
  };

  // InvalidArgument for a scan that is refused and for a stamp beyond all years.
  absl::StatusOr<Reading> Read(int64_t end_stamp_ns);
  // The scan with this stamp was used: later ones are read relative to it.
  void Advance(int64_t end_stamp_ns, int64_t time_ns);

  // For core/state_codec.h.
  template <typename Self, typename Io>
  static void Fields(Self& self, Io& io) {
    io(self.started_, self.has_refused_, self.stamp_ns_, self.time_ns_, self.interval_ns_,
       self.refused_ns_);
    if constexpr (Io::kIsReading) {
      const auto is_time = [](int64_t ns) { return ns >= -kMost_ns && ns <= kMost_ns; };
      io.Expect(is_time(self.stamp_ns_) && is_time(self.time_ns_) && is_time(self.refused_ns_) &&
                self.interval_ns_ > 0);
    }
  }

 private:
  static constexpr int64_t kMost_ns = (int64_t{1} << 62) + (int64_t{1} << 61);

  bool started_ = false;
  bool has_refused_ = false;            // The scan before was refused, for its stamp.
  int64_t stamp_ns_ = 0, time_ns_ = 0;  // Both of the last scan used.
  int64_t interval_ns_ = 100'000'000;   // Between the last two that followed each other.
  int64_t refused_ns_ = 0;              // The stamp of that scan.
};

}  // namespace isthmus
