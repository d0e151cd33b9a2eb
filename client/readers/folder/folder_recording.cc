#include "client/readers/folder/folder_recording.h"

#include <absl/strings/ascii.h>
#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "client/readers/folder/folder_stamps.h"
#include "client/readers/folder/scan_files.h"
#include "client/readers/limits.h"
#include "client/readers/ring_sensor.h"
#include "client/readers/stamps.h"
#include "core/codec/payload_layout.h"
#include "core/formats/cloud_file.h"
#include "core/formats/kitti_bin.h"
#include "core/formats/pcd.h"
#include "core/io/file_io.h"

namespace isthmus::readers {
namespace {

// With the viewpoint, where the file is one that has it.
absl::StatusOr<PointPayload> ReadFormat(const std::filesystem::path& file,
                                        std::optional<Pose>& viewpoint) {
  const std::string extension = absl::AsciiStrToLower(file.extension().string());
  if (extension == ".bin") return formats::ReadKittiBin(file);
  if (extension != ".pcd") return formats::ReadCloudFile(file);
  absl::StatusOr<formats::PcdFile> pcd = formats::ReadPcd(file);
  if (!pcd.ok()) return pcd.status();
  viewpoint = pcd->viewpoint;
  return std::move(pcd->payload);
}

absl::StatusOr<PointPayload> ReadScan(const std::filesystem::path& file,
                                      std::optional<Pose>& viewpoint) {
  absl::StatusOr<PointPayload> scan = ReadFormat(file, viewpoint);
  if (scan.ok() || absl::StrContains(scan.status().message(), file.string())) return scan;
  return absl::Status(scan.status().code(),
                      absl::StrCat(file.string(), ": ", scan.status().message()));
}

// The sensor that simulation.json names; empty where there is none.
std::string SimulatedSensor(const std::filesystem::path& folder) {
  const auto file = FindBeside(folder, "simulation.json");
  if (!file) return "";
  const absl::StatusOr<std::string> text = io::ReadFile(*file);
  if (!text.ok()) return "";
  const auto json = nlohmann::json::parse(*text, nullptr, /*allow_exceptions=*/false);
  if (!json.is_object() || !json.contains("sensor") || !json["sensor"].is_string()) return "";
  return json["sensor"].get<std::string>();
}

// KITTI's odometry drives, and those laid out as they are: their scans are compensated, unlike the
// raw ones.
bool IsKittiOdometry(const ScanFiles& files) {
  return files.extension == ".bin" && WholeName(files.folder).filename() == "velodyne" &&
         FindBeside(files.folder, "calib.txt") && FindBeside(files.folder, "times.txt");
}

std::string OrderText(const ScanFiles& files) {
  if (files.files.size() < 2 || !files.series.pattern.empty()) return "";
  return "scans are in the order of their names, which are no series with numbers";
}

std::string LeftOut(const ScanFiles& files) {
  if (files.left_out.empty()) return "";
  const size_t given = std::min(files.left_out.size(), kNamesGiven);
  const size_t more = files.left_out.size() - given;
  return absl::StrCat("left out, as their names do not fit the series ", files.series.pattern, ": ",
                      absl::StrJoin(files.left_out.begin(), files.left_out.begin() + given, ", "),
                      more > 0 ? absl::StrCat(" and ", more, " more") : "");
}

class FolderReader : public ScanReader {
 public:
  FolderReader(ScanFiles files, FolderStamps stamps, const ReadOptions& options)
      : files_(std::move(files)),
        stamps_(std::move(stamps)),
        drivers_(options.stamps, options.rate_hz) {
    if (!stamps_.only_count || options.compensated == true) points_stamp_ = false;
    sensor_ = SimulatedSensor(files_.folder);
  }

  absl::StatusOr<std::optional<RecordedScan>> Next() override {
    if (next_ == files_.files.size()) return std::nullopt;
    const size_t i = next_++;
    std::optional<Pose> viewpoint;
    absl::StatusOr<PointPayload> payload = ReadScan(files_.files[i], viewpoint);
    if (!payload.ok()) return payload.status();
    RecordedScan scan{stamps_.stamps_ns[i], *std::move(payload), files_.files[i].string(),
                      viewpoint};
    if (absl::Status status = codec::CheckLayout(scan.payload); !status.ok()) {
      return absl::InvalidArgumentError(absl::StrCat(scan.name, ": ", status.message()));
    }
    rings_.Look(scan.payload);
    if (next_ == 1 && files_.extension == ".bin") TellLayout(scan.payload);
    if (stamps_.are_of_drivers) {
      scan.end_stamp_ns = drivers_.End(scan.payload, stamps_.stamps_ns[i], stamps_.stamps_ns[i]);
    }
    if (absl::Status status = StampByPoints(scan); !status.ok()) return status;
    return scan;
  }

  std::optional<uint64_t> size() const override { return files_.files.size(); }
  bool has_stamps() const override { return !stamps_.only_count; }
  std::string sensor() const override { return sensor_.empty() ? rings_.sensor() : sensor_; }
  std::vector<std::string> Assumptions() const override {
    std::vector<std::string> all;
    if (points_stamp_ != true) all = stamps_.origin;
    if (std::string order = OrderText(files_); !order.empty()) all.push_back(std::move(order));
    if (std::string left_out = LeftOut(files_); !left_out.empty()) {
      all.push_back(std::move(left_out));
    }
    if (!layout_.empty()) all.push_back(layout_);
    for (std::string& assumption : drivers_.Assumptions()) all.push_back(std::move(assumption));
    return all;
  }

 private:
  // The first scan tells whether points have a clock that stamps all.
  absl::Status StampByPoints(RecordedScan& scan) {
    if (points_stamp_ == false) return absl::OkStatus();
    const std::optional<int64_t> end_ns = drivers_.ByOwnClock(scan.payload);
    if (points_stamp_ && !end_ns) {
      return absl::InvalidArgumentError(absl::StrCat(
          scan.name, ": its points lack the times of a clock, which stamp the other scans"));
    }
    points_stamp_ = end_ns.has_value();
    scan.end_stamp_ns = end_ns.value_or(scan.end_stamp_ns);
    return absl::OkStatus();
  }
  // The layout of a .bin, which has no header.
  void TellLayout(const PointPayload& payload) {
    if (payload.fields.size() > 4) {
      layout_ = "the columns of the .bin files are taken for x y z intensity ring, by their values";
    } else if (sensor_.empty()) {
      sensor_ = "hdl64";
      layout_ = "the sensor is taken to be an hdl64, as KITTI's: .bin files do not say";
    }
  }

  const ScanFiles files_;
  const FolderStamps stamps_;
  ScanStamps drivers_;                // For stamps of drivers, or of points.
  std::optional<bool> points_stamp_;  // Absent: the first scan is to tell.
  RingSensor rings_;
  size_t next_ = 0;
  std::string sensor_, layout_;
};

class FolderRecording : public Recording {
 public:
  FolderRecording(std::string path, ScanFiles files)
      : path_(std::move(path)), files_(std::move(files)) {
    topics_ = {{.name = "", .type = files_.extension, .messages = files_.files.size()}};
  }

  std::string kind() const override {
    return std::filesystem::is_directory(path_) ? "folder of scans" : "a scan";
  }
  const std::vector<ScanTopic>& scan_topics() const override { return topics_; }

 private:
  bool are_compensated() const override { return IsKittiOdometry(files_); }
  absl::StatusOr<std::unique_ptr<ScanReader>> OpenAllScans(
      size_t, const ReadOptions& options) const override {
    absl::StatusOr<FolderStamps> stamps = StampsOf(files_, options.rate_hz);
    if (!stamps.ok()) return stamps.status();
    return std::make_unique<FolderReader>(files_, *std::move(stamps), options);
  }

  const std::string path_;
  const ScanFiles files_;
  std::vector<ScanTopic> topics_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<Recording>> OpenFolderRecording(const std::string& path) {
  absl::StatusOr<ScanFiles> files = FindScans(path);
  if (!files.ok()) return files.status();
  return std::make_unique<FolderRecording>(path, *std::move(files));
}

}  // namespace isthmus::readers
