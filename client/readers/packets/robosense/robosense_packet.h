// The packets of a RoboSense sensor: points (MSOP), and what the unit is like (DIFOP).
// RS-LiDAR-16, RS-LiDAR-32, RS-Helios and RS-Ruby User Guides, "Communication Protocol".
#pragma once

#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>

#include <cstddef>
#include <cstdint>
#include <string>

#include "client/readers/packets/laser_geometry.h"

namespace isthmus::readers::robosense {

enum class Model : uint8_t { kRs16, kRs32, kHelios16, kHelios32, kRuby80, kRuby128 };

// A model, as its manual describes it.
struct Spec {
  const char* name;
  int lasers;
  int blocks, channels;  // A packet has so many blocks, and a block so many channels.
  size_t first_at;       // The first block begins at this byte.
  double range_unit_m;
  double lens_m;     // From the axis to the lens, along the azimuth.
  double firing_us;  // From one firing of all lasers to the next.
};
const Spec& SpecOf(Model model);

// Microseconds from the start of a block to the firing of a channel. `both`: channels 16 to 31 of
// a model of 16 are the other return of the first, else its next firing.
double ChannelTimeUs(Model model, int channel, bool both);

// A view of an MSOP packet of 1248 bytes.
class Packet {
 public:
  // InvalidArgument, saying why, for what is none of a sensor that is known. Those of a Helios are
  // taken for a Helios-32's.
  static absl::StatusOr<Packet> Parse(absl::string_view bytes);

  Model model() const { return model_; }
  int blocks() const { return blocks_; }  // Blocks that hold something.
  int azimuth(int block) const;           // Hundredths of a degree, below 36000.
  uint16_t range(int block, int channel) const;
  uint8_t intensity(int block, int channel) const;
  // The clock: whole seconds of UTC as nanoseconds, and the rest, in micro- or nanoseconds.
  int64_t whole_ns() const;
  int64_t rest() const;

 private:
  size_t BlockAt(int block) const;

  absl::string_view bytes_;
  Model model_ = Model::kRs16;
  int blocks_ = 0;
};

bool MayBeRobosensePacket(absl::string_view beginning, size_t length);

// A view of a DIFOP packet of 1248 bytes.
bool IsDifop(absl::string_view bytes);
// True if it says that both returns are sent.
bool SendsBothReturns(absl::string_view difop, Model model);

// The angles of `csv` (angle_file.h), else those of `difop`, else the manual's nominal ones; the
// texts may be empty. FailedPrecondition, saying what to give, where none has the model's.
absl::StatusOr<Calibration> FindAngles(const std::string& csv, absl::string_view difop,
                                       Model model);

}  // namespace isthmus::readers::robosense
