// The part of Client that reads the map tile by tile, and watches it.
#include <utility>

#include "api/convert/map_changes.h"
#include "api/convert/map_name.h"
#include "client/library/answer_bound.h"
#include "client/library/client.h"
#include "client/library/list_stream.h"
#include "client/library/received_points.h"

namespace isthmus::client {

using Stubs = Client::Link::Stubs;

absl::StatusOr<TileList> Client::ListTiles(const MapName& map, uint32_t level) {
  v1::ListTilesRequest request;
  convert::PutMap(map, request);
  request.set_level(level);
  const auto open = [&](Stubs& stubs, grpc::ClientContext& context) {
    return stubs.maps->ListTiles(&context, request);
  };
  const auto add = [](const v1::ListTilesResponse& part, TileList& list) {
    list.revision = part.revision();
    list.tile_m = part.tile_m();
    list.levels = part.levels();
    for (const v1::TileInfo& tile : part.tiles()) list.tiles.push_back(convert::FromMessage(tile));
  };
  return ReadList<TileList, v1::ListTilesResponse>(*link_, open, add);
}

absl::StatusOr<MapTile> Client::GetTile(const TileId& id, uint64_t have_version) {
  v1::GetTileRequest request;
  *request.mutable_id() = convert::ToMessage(id);
  request.set_have_version(have_version);
  request.set_form(v1::GetTileRequest::CLOUD);
  MapTile tile;
  absl::Status failure;  // Found on this side.
  const auto read = [&](Stubs& stubs, grpc::ClientContext& context) {
    tile = {};
    AnswerBound bound(link_->options().max_answer_bytes);
    auto reader = stubs.maps->GetTile(&context, request);
    for (v1::GetTileResponse part; failure.ok() && reader->Read(&part);) {
      tile.revision = part.revision();
      tile.not_modified = part.not_modified();
      if (part.has_info()) tile.info = convert::FromMessage(part.info());
      for (const std::string& robot : part.robots()) tile.robots.emplace_back(robot);
      failure = bound.Add(part.ByteSizeLong());
      if (failure.ok()) failure = AppendReceived(std::move(*part.mutable_cloud()), &tile.points);
      if (!failure.ok()) context.TryCancel();
    }
    return reader->Finish();
  };
  const absl::Status status = link_->Call(link_->options().transfer_timeout_s, read);
  if (!failure.ok()) return failure;
  if (!status.ok()) return status;
  return tile;
}

absl::Status Client::WatchMap(MapMark known, uint32_t level, const OnStep& take) {
  bool goes_on = true;
  // One connection, as long as it lasts.
  const auto watch = [&]() -> absl::Status {
    const std::shared_ptr<Stubs> stubs = link_->Get();
    grpc::ClientContext context;
    link_->Attach(context);
    v1::WatchMapRequest request;
    request.set_from_revision(known.revision);
    request.set_run(known.run);
    request.set_level(level);
    const auto reader = stubs->maps->WatchMap(&context, request);
    bool has_heard = false;
    MapStep step;
    AnswerBound bound(link_->options().max_answer_bytes);
    absl::Status failure;  // Found on this side.
    for (v1::WatchMapResponse part; goes_on && reader->Read(&part);) {
      has_heard = true;
      if (failure = bound.Add(part.ByteSizeLong()); !failure.ok()) break;
      convert::AddPart(part, &step);
      if (part.more()) continue;
      known = step.mark;
      goes_on = take(step);
      step = {};
      bound.Restart();
    }
    if (!goes_on || !failure.ok()) context.TryCancel();
    const absl::Status status = ToStatus(reader->Finish());
    if (!goes_on) return absl::OkStatus();
    if (!failure.ok()) return failure;
    if (absl::IsUnavailable(status)) link_->Renew(stubs);
    return has_heard && absl::IsUnavailable(status) ? absl::OkStatus() : status;
  };
  absl::Status status;
  while (goes_on && status.ok()) status = link_->Repeat(false, watch);
  return status;
}

}  // namespace isthmus::client
