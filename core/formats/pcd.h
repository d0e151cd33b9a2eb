// Point Cloud Library's PCD files, versions 0.5 to 0.7, read and written without PCL.
// https://pointclouds.org/documentation/tutorials/pcd_file_format.html
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <string>

#include "core/point_payload.h"
#include "core/pose.h"

namespace isthmus::formats {

enum class PcdEncoding { kAscii, kBinary, kBinaryCompressed };

struct PcdFile {
  PointPayload payload;  // Raw. 8-byte integers, which it has no type for, become float64.
  Pose viewpoint;        // T_data_sensor of the acquisition; identity unless the file says so.
  PcdEncoding encoding = PcdEncoding::kBinary;
};

// Bytes behind the announced points are not looked at, and a value that nothing needs and its field
// cannot hold is NaN or 0 (pcd_header.h, pcd_ascii.h). InvalidArgument, naming the line or the
// number that is wrong, for a header that is incomplete or contradicts itself, for less data than
// it announces, and for damaged data. The memory allocated is bounded by the size of `bytes` (by
// 100 times it for binary_compressed). An empty cloud is no error.
absl::StatusOr<PcdFile> ParsePcd(const std::string& bytes);

// NotFound, PermissionDenied or Unavailable when the file cannot be read; messages carry the path.
absl::StatusOr<PcdFile> ReadPcd(const std::string& path);

// The bytes of a file. InvalidArgument for a payload that is not raw, whose layout does not fit
// its data, or that is larger than binary_compressed can hold (4 GiB).
absl::StatusOr<std::string> FormatPcd(const PointPayload& raw, PcdEncoding encoding,
                                      const Pose& viewpoint = {});

// Replaces the file. ResourceExhausted when the disk is full.
absl::Status WritePcd(const std::string& path, const PointPayload& raw, PcdEncoding encoding,
                      const Pose& viewpoint = {});

}  // namespace isthmus::formats
