#include <algorithm>
#include <chrono>
#include <memory>

#include "client/exports/cloud_files.h"
#include "core/formats/las_writer.h"
#include "core/io/headed_output.h"

namespace isthmus::exports {
namespace {

absl::StatusOr<formats::LasOptions> LasOptionsOf(const std::vector<RobotId>& robots,
                                                 const std::optional<earth::Site>& site) {
  formats::LasOptions options;
  options.robots = robots;
  options.created_ns = std::chrono::duration_cast<std::chrono::nanoseconds>(
                           std::chrono::system_clock::now().time_since_epoch())
                           .count();
  if (!site) return options;
  auto wkt = site->UtmWkt();
  if (!wkt.ok()) return wkt.status();
  options.wkt = *std::move(wkt);
  options.offset = site->ToUtm(Eigen::Vector3d::Zero()).array().floor();
  return options;
}

Eigen::Vector3d MapPosition(const MapPoint& point) {
  return {double{point.x}, double{point.y}, double{point.z}};
}

// Begins with the first piece, which names the robots.
class LasFile {
 public:
  LasFile(const std::string& path, const std::optional<earth::Site>& site)
      : path_(path), site_(site) {}

  absl::Status Add(const RegionChunk& chunk) {
    if (!writer_) {
      if (absl::Status status = Begin(chunk.robots); !status.ok()) return status;
    }
    if (chunk.points.empty()) return absl::OkStatus();
    if (!site_) return output_->Append(writer_->Points(chunk.points, MapPosition));
    return output_->Append(writer_->Points(
        chunk.points, [this](const MapPoint& point) { return site_->ToUtm(MapPosition(point)); }));
  }
  absl::Status Commit() { return output_->Commit(writer_->Header()); }
  uint64_t points() const { return writer_ ? writer_->count() : 0; }

 private:
  absl::Status Begin(const std::vector<RobotId>& robots) {
    auto options = LasOptionsOf(robots, site_);
    if (!options.ok()) return options.status();
    writer_.emplace(*std::move(options));
    output_.emplace(path_, writer_->HeaderSize());
    return output_->Open();
  }

  const std::string path_;
  const std::optional<earth::Site> site_;
  std::optional<formats::LasWriter> writer_;
  std::optional<io::HeadedOutput> output_;
};

}  // namespace

absl::StatusOr<CloudSummary> WriteLas(client::Client& client, const RegionQuery& query,
                                      const std::optional<earth::Site>& site,
                                      const std::string& path, const CloudProgress& progress) {
  LasFile file(path, site);
  CloudSummary summary;
  absl::Status failure;
  const absl::Status read = client.QueryRegion(query, [&](const RegionChunk& chunk) {
    summary.revision = chunk.revision;
    failure = file.Add(chunk);
    if (progress) progress(file.points());
    return failure.ok();
  });
  if (!failure.ok()) return failure;
  if (!read.ok()) return read;
  summary.points = file.points();
  if (absl::Status status = file.Commit(); !status.ok()) return status;
  return summary;
}

}  // namespace isthmus::exports
