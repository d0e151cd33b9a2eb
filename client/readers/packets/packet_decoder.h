// Packets of a LiDAR, made into scans: what files, sockets and messages of packets have in common.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "client/readers/scan_reader.h"

namespace isthmus::readers {

// Decodes the packets of one sensor. Not thread safe.
class PacketDecoder {
 public:
  virtual ~PacketDecoder() = default;

  // Takes the payload of a UDP packet that arrived at that time (nanoseconds since the Unix epoch),
  // and appends the scans that it completes. InvalidArgument for what is no packet of this sensor:
  // nothing has happened then. FailedPrecondition, now and ever after, where the sensor that the
  // packets tell cannot be read with what was given; the message says what to give.
  virtual absl::Status Add(absl::string_view packet, int64_t arrival_ns,
                           std::vector<RecordedScan>* scans) = 0;
  // Ends the scan that was begun: appends it unless it is empty. At the end of a recording, and
  // behind the last packet of a message that is a whole turn.
  virtual void Flush(std::vector<RecordedScan>* scans) = 0;

  // As those of ScanReader.
  virtual std::string sensor() const = 0;
  virtual std::vector<std::string> Assumptions() const = 0;
};

struct PacketOptions {
  std::string sensor = {};       // "vlp16", "Pandar64"; empty: as the packets tell.
  std::string calibration = {};  // Contents of a calibration; empty: the manual's tables.
  // A scan of a sensor that spins begins where the azimuth passes this (degrees, clockwise from +y
  // of the sensor's manual, as in the packets).
  double cut_azimuth_deg = 0;
  // Scans are cut by Flush alone: messages are whole turns.
  bool by_flush = false;
  // The sensor's clock is known to be UTC, as its position packets say, and arrival plus this is
  // UTC to within some minutes.
  std::optional<int64_t> utc_offset_ns = std::nullopt;
};

// Points come as in the packets: block by block, laser by laser; fields are x y z intensity ring
// time, rings count from the lowest laser up. Of two returns the second block's point comes after
// all of the first block's, and is left out where its range is the same. The VLP-16, Puck LITE and
// Puck Hi-Res, VLP-32C, HDL-32E, HDL-64E (S2, S3) and VLS-128 are known. InvalidArgument for a
// sensor that is not, or a calibration (YAML) that cannot be read; an HDL-64E without one is
// refused by Add, since each unit has its own.
absl::StatusOr<std::unique_ptr<PacketDecoder>> MakeVelodyneDecoder(const PacketOptions& options);

// The same for Hesai's sensors (hesai_model.h). Their calibration is the CSV of the unit's angles,
// which QT64, QT128 and OT128 need. Points are in the frame of the maker's manuals and drivers: y
// at azimuth 0, x at 90 degrees.
absl::StatusOr<std::unique_ptr<PacketDecoder>> MakeHesaiDecoder(const PacketOptions& options);

// The same for Livox' sensors, which have no calibration and do not spin: scans are cut each 100
// ms, and points have a tag, as the maker's drivers give it.
absl::StatusOr<std::unique_ptr<PacketDecoder>> MakeLivoxDecoder(const PacketOptions& options);

// The same for RoboSense's RS-LiDAR-16 and -32, Helios-16 and -32, Ruby-80 and -128, in the frame
// of their manuals: x at azimuth 0. Angles are those of a CSV of the unit, else of the sensor's own
// DIFOP packets, which Add takes, too; an RS-LiDAR-16 has nominal ones.
absl::StatusOr<std::unique_ptr<PacketDecoder>> MakeRobosenseDecoder(const PacketOptions& options);

// `metadata`: the sensor's JSON, of any firmware from 2.0 on. InvalidArgument where something is
// missing in it or is not supported, naming it. Add refuses the packets of another unit
// (FailedPrecondition), which all but those of the profile LEGACY name.
absl::StatusOr<std::unique_ptr<PacketDecoder>> MakeOusterDecoder(const std::string& metadata);

// True for packets of that maker's point data, by their size and what they begin with. Ouster's
// need the metadata to be told.
bool IsVelodynePacket(absl::string_view packet);

}  // namespace isthmus::readers
