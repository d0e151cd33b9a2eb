// Recorded drives, whatever they were recorded in.
#pragma once

#include <absl/status/statusor.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "client/readers/scan_reader.h"
#include "core/pose.h"

namespace isthmus::readers {

// The instant of a scan that its stamp means, if the recording leaves that open.
enum class StampMeaning : uint8_t {
  kByTimes,  // As the times of the points say; without such, the END.
  kStart,
  kEnd,
};

struct ReadOptions {
  std::string sensor = {};  // A name of sensor_model.h; empty: as the recording tells.
  // Scans per second: where nothing stamps them, scan i ended at i / rate_hz seconds, and where
  // stamps are those of the start and points have no times, a scan took so long.
  double rate_hz = 10;
  StampMeaning stamps = StampMeaning::kByTimes;
  // Points are where they were at the scan's stamp, whatever that is of, and their times mean
  // nothing; absent: as the recording tells. False: times that are all 0 are none.
  std::optional<bool> compensated = std::nullopt;
  std::string metadata = {};     // Ouster's JSON; empty: that beside or in the recording.
  std::string calibration = {};  // The unit's, as PacketOptions'; empty: the manual's tables.
  // First and last scan to take, counted from 0 in the whole recording; the others' stamps stay.
  size_t from = 0;
  std::optional<size_t> to = std::nullopt;  // Included; absent: the last one.
};

// Something in a recording that scans can be read from.
struct ScanTopic {
  std::string name;  // "/alice/points", "udp 2368 from 192.168.1.201"; empty in a folder of scans.
  std::string type;  // "sensor_msgs/PointCloud2", "Velodyne packets", ".bin"
  std::optional<uint64_t> messages = std::nullopt;  // Or packets or files, where that is known.
};

// A fix of a GNSS receiver, as sensor_msgs/NavSatFix: WGS 84, degrees and metres above the
// ellipsoid.
struct GnssFix {
  int64_t stamp_ns = 0;
  double latitude_deg = 0, longitude_deg = 0, altitude_m = 0;
  // One sigma, metres; 0: not known.
  double sigma_east_m = 0, sigma_north_m = 0, sigma_up_m = 0;
  std::string frame;  // The antenna's.
};

struct GnssTopic {
  std::string name;
  std::optional<uint64_t> messages = std::nullopt;
};

// An edge of /tf_static.
struct StaticTransform {
  std::string parent, child;
  Pose T_parent_child;
};

// Thread safe: readers of several topics may be used beside each other.
class Recording {
 public:
  virtual ~Recording() = default;

  virtual std::string kind() const = 0;  // "ROS 1 bag", "folder of scans"
  virtual const std::vector<ScanTopic>& scan_topics() const = 0;
  // Other contents of the file, and damage found when it was opened, in words.
  virtual std::vector<std::string> notes() const { return {}; }

  // Reads the scans of scan_topics()[topic] from the beginning, none twice. InvalidArgument for
  // options that do not fit the recording, NotFound for a file that they name.
  absl::StatusOr<std::unique_ptr<ScanReader>> OpenScans(size_t topic,
                                                        const ReadOptions& options) const;

  virtual std::vector<GnssTopic> gnss_topics() const { return {}; }
  // The valid fixes, in the order of the recording.
  virtual absl::StatusOr<std::vector<GnssFix>> ReadFixes(size_t gnss_topic) const;
  virtual absl::StatusOr<std::vector<StaticTransform>> ReadStaticTransforms() const;

 private:
  // True where scans are known to be motion-compensated.
  virtual bool are_compensated() const { return false; }
  // All scans: `from`, `to` and `compensated` of the options are seen to.
  virtual absl::StatusOr<std::unique_ptr<ScanReader>> OpenAllScans(
      size_t topic, const ReadOptions& options) const = 0;
};

// Opens a folder or a file of scans, a .pcap, .bag, .mcap or .db3 (or the folder of a ROS 2 bag),
// or a live sensor, udp://[ADDRESS]:PORT. What a file is, is told by its first bytes where they
// tell. NotFound for what is not there or holds nothing that scans can be read from;
// InvalidArgument for what is none of these.
absl::StatusOr<std::unique_ptr<Recording>> OpenRecording(const std::string& path);

}  // namespace isthmus::readers
