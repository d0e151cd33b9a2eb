// The part of Client that reads the points of the map.
#include <string>
#include <utility>

#include "api/convert/cloud.h"
#include "api/convert/map.h"
#include "client/library/answer_bound.h"
#include "client/library/client.h"
#include "client/library/link.h"
#include "client/library/received_points.h"
#include "core/codec/draco_cloud.h"
#include "core/codec/quantized.h"

namespace isthmus::client {

using Stubs = Client::Link::Stubs;

absl::Status AppendReceived(v1::PointCloud&& cloud, std::vector<MapPoint>* points) {
  const auto damaged = [](const absl::Status& status) {
    return absl::DataLossError("points from the server: " + std::string(status.message()));
  };
  if (cloud.width() == 0 && cloud.data().empty()) return absl::OkStatus();
  absl::StatusOr<PointPayload> payload = convert::FromServer(std::move(cloud));
  if (!payload.ok()) return damaged(payload.status());
  if (payload->encoding != PayloadEncoding::kRaw) {
    payload = payload->encoding == PayloadEncoding::kDraco ? codec::UnpackDraco(*payload)
                                                           : codec::Dequantize(*payload);
    if (!payload.ok()) return damaged(payload.status());
  }
  return convert::AppendPoints(*payload, *points);
}

absl::Status Client::QueryRegion(const RegionQuery& query,
                                 const std::function<bool(const RegionChunk&)>& chunk) {
  v1::QueryRegionRequest request = convert::ToMessage(query);
  RegionChunk out;
  absl::Status failure;  // Found on this side.
  AnswerBound bound(link_->options().max_file_bytes);
  bool has_started = false;
  const auto read = [&](Stubs& stubs, grpc::ClientContext& context) {
    auto reader = stubs.maps->QueryRegion(&context, request);
    for (v1::QueryRegionResponse part; failure.ok() && reader->Read(&part);) {
      const bool is_head = has_started && part.cloud().width() == 0;
      out.revision = part.revision();
      out.resolution_m = part.resolution_m();
      out.next = convert::FromMessage(part.next());
      if (!part.robots().empty()) out.robots.clear();
      for (const std::string& robot : part.robots()) out.robots.emplace_back(robot);
      out.points.clear();
      failure = bound.Add(part.ByteSizeLong());
      if (failure.ok()) failure = AppendReceived(std::move(*part.mutable_cloud()), &out.points);
      has_started = true;
      if (part.has_next()) *request.mutable_resume() = part.next();
      // Once is enough for what begins an answer.
      if (failure.ok() && !is_head && !chunk(out)) {
        failure = absl::CancelledError("stopped by the reader");
      }
      if (!failure.ok()) context.TryCancel();
    }
    return reader->Finish();
  };
  const absl::Status status = link_->Repeat(false, [&] {
    absl::Status once = link_->Once(link_->options().transfer_timeout_s, read);
    // It goes on behind what came, where the server can tell where that is.
    if (has_started && !request.has_resume()) return NotAgain(once);
    const bool is_lost = has_started && absl::IsFailedPrecondition(once) && !query.resume;
    return is_lost ? absl::AbortedError(once.message()) : once;
  });
  return failure.ok() ? status : failure;
}

}  // namespace isthmus::client
