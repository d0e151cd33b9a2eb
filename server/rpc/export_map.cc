#include "server/rpc/export_map.h"

#include <absl/strings/str_cat.h>

#include <optional>
#include <string>

#include "server/rpc/convert.h"
#include "server/rpc/file_emitter.h"

namespace isthmus::rpc {
namespace {

constexpr double kDefaultLeafM = 0.2;  // As the API says.

std::optional<server::ExportFormat> FromProto(v1::ExportMapRequest::Format format) {
  switch (format) {
    case v1::ExportMapRequest::PCD_ASCII:
      return server::ExportFormat::kPcdAscii;
    case v1::ExportMapRequest::PCD_BINARY:
      return server::ExportFormat::kPcdBinary;
    case v1::ExportMapRequest::PCD_BINARY_COMPRESSED:
      return server::ExportFormat::kPcdBinaryCompressed;
    case v1::ExportMapRequest::PLY:
      return server::ExportFormat::kPly;
    case v1::ExportMapRequest::OCTOMAP_BINARY:
      return server::ExportFormat::kOctoMapBinary;
    case v1::ExportMapRequest::OCTOMAP_FULL:
      return server::ExportFormat::kOctoMapFull;
    default:
      return std::nullopt;
  }
}

}  // namespace

absl::Status ExportMap(server::Pipeline& pipeline, const v1::ExportMapRequest& request,
                       const Emit<v1::ExportMapResponse>& emit) {
  const auto format = FromProto(request.format());
  if (!format) {
    return absl::InvalidArgumentError(
        "name the format of the file: PCD_ASCII, PCD_BINARY, PCD_BINARY_COMPRESSED, PLY, "
        "OCTOMAP_BINARY or OCTOMAP_FULL");
  }
  const double resolution_m = request.resolution_m();
  if (!(resolution_m >= 0 && resolution_m <= kMaxCoordinateM)) {
    return absl::InvalidArgumentError(absl::StrCat("resolution_m is ", resolution_m,
                                                   ": give a positive size, or 0 for the default"));
  }
  Region region;
  region.component = request.component();
  region.resolution_m = resolution_m;
  FileEmitter<v1::ExportMapResponse> file(pipeline.GetMap()->revision(), emit);
  const absl::Status status =
      pipeline.ExportMap(*format, region, resolution_m > 0 ? resolution_m : kDefaultLeafM,
                         [&file](const std::string& piece) { return file.Add(piece); });
  if (!status.ok()) return status;
  return file.Finish() ? absl::OkStatus() : ReaderGone();
}

}  // namespace isthmus::rpc
