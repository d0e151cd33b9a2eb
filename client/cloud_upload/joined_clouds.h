// Several LiDARs of one robot, read as one.
#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "client/readers/scan_reader.h"
#include "core/pose.h"

namespace isthmus::cloud_upload {

struct MountedClouds {
  std::unique_ptr<readers::ScanReader> reader;
  Pose T_leading_sensor;
};

// Clouds of the leading LiDAR, each with those of the others that were taken within kSameTurnNs, in
// the leading one's frame at its own stamp, as x y z intensity (float32). A cloud is joined once,
// one that none is near to is left out. Errors of any reader are returned as they come; the clouds
// before and behind are read all the same. Not thread safe, but for Interrupt.
class JoinedClouds : public readers::ScanReader {
 public:
  // The leading sensor's motion, T_to_from: where it was at `from_ns`, seen from where it was at
  // `to_ns`; empty where that is not known: the cloud is left out.
  using Motion = std::function<std::optional<Pose>(int64_t to_ns, int64_t from_ns)>;

  JoinedClouds(std::unique_ptr<readers::ScanReader> leading, std::vector<MountedClouds> others,
               Motion motion);

  absl::StatusOr<std::optional<readers::RecordedScan>> Next() override;
  std::optional<uint64_t> size() const override { return leading_->size(); }
  std::string sensor() const override { return leading_->sensor(); }
  bool has_stamps() const override { return leading_->has_stamps(); }
  std::vector<std::string> Assumptions() const override { return leading_->Assumptions(); }
  void Interrupt() override;

 private:
  struct Other {
    MountedClouds clouds;
    std::optional<readers::RecordedScan> before, after;  // Around the leading cloud, not yet used.
    bool has_ended = false;
  };
  // Reads until `after` is later than the stamp.
  void ReadOn(int64_t stamp_ns, Other& other);
  absl::Status Join(const readers::RecordedScan& cloud, int64_t stamp_ns,
                    const Pose& T_leading_sensor, std::string& points);

  const std::unique_ptr<readers::ScanReader> leading_;
  std::vector<Other> others_;
  const Motion motion_;
  std::deque<absl::Status> errors_;
};

}  // namespace isthmus::cloud_upload
