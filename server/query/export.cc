#include "server/query/export.h"

#include <absl/status/statusor.h>

#include <vector>

#include "core/formats/map_writer.h"
#include "server/query/limits.h"

namespace isthmus::query {
namespace {

absl::Status Stopped() { return absl::CancelledError("The reader stopped the export"); }

// A map never changes, so a second reading gives the points that were counted.
absl::StatusOr<uint64_t> CountPoints(const ComposedMap& map, const Region& region) {
  const bool is_whole = region.box.empty() && !region.has_sphere && region.robot < 0 &&
                        !(region.resolution_m > 0) && region.classes.has_all();
  if (is_whole && map.ready().ok()) return map.point_count(region.component);
  uint64_t count = 0;
  const absl::Status status =
      map.Read(region, kPointsPerPiece, [&](const std::vector<MapPoint>& points) {
        count += points.size();
        return true;
      });
  if (!status.ok()) return status;
  return count;
}

// The header, then every chunk as `format_chunk` puts it.
template <typename FormatChunk>
absl::Status Stream(const ComposedMap& map, const Region& region, const std::string& header,
                    const FormatChunk& format_chunk, const ByteSink& sink) {
  if (!sink(header)) return Stopped();
  bool wanted = true;
  const absl::Status status = map.Read(
      region, kPointsPerPiece,
      [&](const std::vector<MapPoint>& points) { return wanted = sink(format_chunk(points)); });
  return wanted ? status : Stopped();
}

absl::Status StreamPcd(const ComposedMap& map, const Region& region, formats::PcdEncoding encoding,
                       const ByteSink& sink) {
  const absl::StatusOr<uint64_t> count = CountPoints(map, region);
  if (!count.ok()) return count.status();
  const std::string header = formats::PcdMapHeader(*count, encoding, map.robots());
  const auto chunk = [&](const std::vector<MapPoint>& points) {
    return formats::PcdMapChunk(points, encoding);
  };
  return Stream(map, region, header, chunk, sink);
}

// PCL compresses whole columns, so this one encoding needs all points at once.
absl::Status SendCompressedPcd(const ComposedMap& map, const Region& region, const ByteSink& sink) {
  const absl::StatusOr<uint64_t> count = CountPoints(map, region);
  if (!count.ok()) return count.status();
  std::vector<MapPoint> all;
  all.reserve(*count);
  const absl::Status status =
      map.Read(region, kPointsPerPiece, [&](const std::vector<MapPoint>& points) {
        all.insert(all.end(), points.begin(), points.end());
        return true;
      });
  if (!status.ok()) return status;
  const absl::StatusOr<std::string> body = formats::PcdMapCompressed(all);
  if (!body.ok()) return body.status();
  const std::string header =
      formats::PcdMapHeader(all.size(), formats::PcdEncoding::kBinaryCompressed, map.robots());
  if (!sink(header)) return Stopped();
  for (size_t begin = 0; begin < body->size(); begin += kBytesPerPiece) {
    if (!sink(body->substr(begin, kBytesPerPiece))) return Stopped();
  }
  return absl::OkStatus();
}

absl::Status StreamPly(const ComposedMap& map, const Region& region, const ByteSink& sink) {
  const absl::StatusOr<uint64_t> count = CountPoints(map, region);
  if (!count.ok()) return count.status();
  const std::string header = formats::PlyMapHeader(*count, map.robots());
  return Stream(map, region, header, formats::PlyMapChunk, sink);
}

}  // namespace

absl::Status ExportCloud(const ComposedMap& map, const Region& region, CloudFormat format,
                         const ByteSink& sink) {
  switch (format) {
    case CloudFormat::kPcdAscii:
      return StreamPcd(map, region, formats::PcdEncoding::kAscii, sink);
    case CloudFormat::kPcdBinary:
      return StreamPcd(map, region, formats::PcdEncoding::kBinary, sink);
    case CloudFormat::kPcdBinaryCompressed:
      return SendCompressedPcd(map, region, sink);
    case CloudFormat::kPly:
      return StreamPly(map, region, sink);
  }
  return absl::InvalidArgumentError("Unknown cloud format");
}

}  // namespace isthmus::query
