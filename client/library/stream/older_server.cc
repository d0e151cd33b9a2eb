#include "client/library/stream/older_server.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "api/convert/cloud.h"
#include "core/codec/quantized.h"

namespace isthmus::client {

ScanSource::Request ForServer(ScanSource::Request request, uint32_t quantized_version) {
  const uint32_t reads = std::max(quantized_version, 1u);
  if (request->scan().cloud().encoding() != v1::PointCloud::QUANTIZED ||
      reads >= static_cast<uint32_t>(kQuantizedVersion)) {
    return request;
  }
  const absl::StatusOr<PointPayload> cloud =
      convert::FromMessage(v1::PointCloud(request->scan().cloud()));
  if (!cloud.ok() || codec::QuantizedVersionOf(*cloud) <= static_cast<int>(reads)) return request;
  const absl::StatusOr<PointPayload> raw = codec::Dequantize(*cloud);
  if (!raw.ok()) return request;
  absl::StatusOr<PointPayload> older =
      codec::Quantize(*raw, cloud->resolution_m, static_cast<int>(reads));
  if (!older.ok()) return request;
  auto changed = std::make_shared<v1::StreamScansRequest>(*request);
  *changed->mutable_scan()->mutable_cloud() = convert::ToMessage(*std::move(older));
  return changed;
}

}  // namespace isthmus::client
