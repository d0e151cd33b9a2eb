// Bytes of anybody, taken for a scan, the header of a submap, or points of a map as they travel:
// parsed, converted, unpacked and decoded as the server does, points as a client does.
#include <cstdint>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

#include "api/convert/cloud.h"
#include "api/convert/session.h"
#include "core/codec/payload_layout.h"
#include "core/codec/scan_decoder.h"
#include "isthmus/v1/map_service.pb.h"
#include "isthmus/v1/session_service.pb.h"

namespace isthmus {
namespace {

void TryScan(const std::string& bytes) {
  v1::StreamScansRequest request;
  if (!request.ParseFromString(bytes) || !request.has_scan()) return;
  const int64_t end_stamp_ns = request.scan().end_stamp_ns();
  auto payload = convert::FromMessage(std::move(*request.mutable_scan()->mutable_cloud()));
  if (!payload.ok()) return;
  for (const uint32_t rings : {0, 16}) {
    const auto scan = codec::DecodeScan(*payload, rings, end_stamp_ns);
    // No more points than the payload said, whose number is bounded by what it may decode to.
    if (scan.ok() && scan->points.size() > codec::kMaxDecodedBytes) std::abort();
  }
}

void TryUpload(const std::string& bytes) {
  v1::UploadSubmapHeader header;
  if (!header.ParseFromString(bytes)) return;
  const auto upload = convert::FromMessage(std::move(header));
  if (!upload.ok()) return;
  (void)codec::CheckLayout(upload->cloud);
}

void TryMapPoints(const std::string& bytes) {
  v1::QueryRegionResponse response;
  if (!response.ParseFromString(bytes)) return;
  std::vector<MapPoint> points;
  const auto payload = convert::FromServer(std::move(*response.mutable_cloud()));
  if (!payload.ok()) return;
  if (!convert::AppendPoints(*payload, points).ok() && !points.empty()) std::abort();
}

}  // namespace
}  // namespace isthmus

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size == 0) return 0;
  const std::string bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
  if (data[0] == 'u') {
    isthmus::TryUpload(bytes);
  } else if (data[0] == 'm') {
    isthmus::TryMapPoints(bytes);
  } else {
    isthmus::TryScan(bytes);
  }
  return 0;
}
