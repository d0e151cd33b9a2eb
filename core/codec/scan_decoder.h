// The decoder that turns a cloud as it was sent into a scan as the odometry takes it.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <string>

#include "core/codec/point_times.h"
#include "core/point_payload.h"
#include "core/scan.h"

namespace isthmus::codec {

// The meanings that the fields of a scan were given, in words.
struct ScanFields {
  std::string ring;  // "field 'ring'", "columns of the cloud"; empty when there is none.
  // "field 't' (ns, from the start of the scan), 3 points left out for odd times", of all scans so
  // far; empty when there is none.
  std::string time;
};

// Decodes the scans of one sensor, one after the other. Not thread safe.
//
// Reads a raw or quantised payload. Fields are found by name, whatever the case of its letters and
// of any scalar type:
//   x y z                    metres, required
//   intensity                or i, reflectivity, signal
//   ring                     or ring_id, channel, line, row, laser_id, laser, beam, beam_id
//   time                     or t, timestamp and others: see time_field.h
// Without a ring field the rows of an organised cloud (height > 1) are the rings, or its columns,
// as elevations tell (ring_lines.h). Rings that count from the highest laser down (Ouster) are
// turned round, so that ring 0 is the lowest.
//
// Times may be relative to the start or the end of the scan or those of a clock, in s, ms, us or
// ns: one turn takes 0.02 to 0.5 s, which only one of these units explains; times since 1970 tell
// their unit by their magnitude. A shorter span is taken as ns in an integer field and as s in a
// floating-point one. Counters may start again within the scan: 32-bit ones, those of the hour and
// of the second. 4294967295 in a uint32 field is no time: the point has that of the return before
// it. The unit is that of most points, two thirds at least, and of all scans: a point whose time
// cannot lie in one turn with theirs is dropped and counted. Times become seconds relative to the
// scan's END, which is the time of the latest return, and in scans that miss a part of the turn
// where it was in whole ones. All 0, before there were others, they stay so: the scan is
// motion-compensated already. If no unit fits, has_time stays false.
//
// No-returns (NaN, infinite, nearer than 1 mm or farther than 100 km) are dropped, order is kept.
class ScanDecoder {
 public:
  // InvalidArgument, naming what is wrong, for a layout that does not fit its data (see
  // CheckLayout), missing x y z, damaged compression, a ring outside [0, 65535], and for a scan
  // without any return.
  absl::StatusOr<Scan> Decode(const PointPayload& payload, uint64_t sequence, int64_t end_stamp_ns);

  // The fields of the last scan that was decoded.
  const ScanFields& fields() const { return fields_; }

  // The knowledge of the sensor's times, from the scans so far: with it another decoder goes on as
  // this one would.
  TimeReader::Memory memory() const { return times_.memory(); }
  void Restore(const TimeReader::Memory& memory) { times_.Restore(memory); }

 private:
  absl::StatusOr<Scan> DecodeRaw(const PointPayload& raw, int64_t end_stamp_ns);

  TimeReader times_;
  uint64_t odd_times_ = 0;
  ScanFields fields_;
};

// The only scan of its sensor.
absl::StatusOr<Scan> DecodeScan(const PointPayload& payload, uint64_t sequence,
                                int64_t end_stamp_ns);

}  // namespace isthmus::codec
