#include "client/cloud_upload/columns.h"

#include <absl/strings/str_cat.h>

#include "core/codec/payload_layout.h"

namespace isthmus::cloud_upload {

absl::StatusOr<std::vector<std::vector<double>>> ReadColumns(const PointPayload& cloud) {
  if (absl::Status status = codec::CheckRawLayout(cloud); !status.ok()) return status;
  std::vector<std::vector<double>> columns;
  for (const char* name : {"x", "y", "z"}) {
    const PointField* field = codec::FindField(cloud, {name});
    if (field == nullptr) {
      return absl::InvalidArgumentError(absl::StrCat("the cloud has no field ", name));
    }
    columns.push_back(codec::ReadColumn(cloud, *field));
  }
  const PointField* intensity = codec::FindField(cloud, {"intensity", "i", "reflectivity"});
  columns.push_back(intensity == nullptr ? std::vector<double>()
                                         : codec::ReadColumn(cloud, *intensity));
  return columns;
}

}  // namespace isthmus::cloud_upload
