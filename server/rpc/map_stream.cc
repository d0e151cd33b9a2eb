#include "server/rpc/map_stream.h"

#include <absl/strings/str_cat.h>

#include <utility>

#include "api/convert/graph.h"
#include "api/convert/map_changes.h"
#include "server/rpc/responses.h"
#include "server/rpc/streams/messages.h"

namespace isthmus::rpc {

size_t StepParts::size() const {
  return step_.tiles.size() + step_.removed_tiles.size() + step_.submaps.size() +
         step_.matches.size() + step_.removed_matches.size();
}

void StepParts::Add(size_t index, v1::WatchMapResponse* response) const {
  const auto is_in = [&index](const auto& list) {
    if (index < list.size()) return true;
    index -= list.size();
    return false;
  };
  if (is_in(step_.tiles)) {
    *response->add_tiles() = convert::ToMessage(step_.tiles[index]);
  } else if (is_in(step_.removed_tiles)) {
    *response->add_removed_tiles() = convert::ToMessage(step_.removed_tiles[index]);
  } else if (is_in(step_.submaps)) {
    *response->add_submaps() = convert::ToMessage(step_.submaps[index]);
  } else if (is_in(step_.matches)) {
    *response->add_matches() = convert::ToMessage(step_.matches[index]);
  } else {
    v1::SessionPair& pair = *response->add_removed_matches();
    pair.set_session_a(step_.removed_matches[index].first.value());
    pair.set_session_b(step_.removed_matches[index].second.value());
  }
}

v1::WatchMapResponse StepParts::Next() {
  // Parts between two looks at the size: each takes a kilobyte at most, but for texts of matches.
  constexpr size_t kLook = 256;
  v1::WatchMapResponse response;
  response.set_revision(step_.mark.revision);
  response.set_run(step_.mark.run);
  response.set_restart(step_.restart);
  response.set_tile_m(step_.tile_m);
  const size_t end = size();
  for (size_t added = 1; at_ < end; ++added) {
    Add(at_++, &response);
    if (added % kLook == 0 && response.ByteSizeLong() > kResponseBytes) break;
  }
  response.set_more(at_ < end);
  return response;
}

MapStream::MapStream(StreamHost* host, grpc::CallbackServerContext* context,
                     const grpc::ByteBuffer* request)
    : MapStreamBase(host, &host->watches, context, "WatchMap"),
      robots_timer_(&host->watchdog, [this] {
        Post([this] {
          are_robots_due_ = true;
          SendNext();
        });
      }) {
  SetRequest(*request);
}

absl::Status MapStream::BeginWatch(grpc::ByteBuffer* message) {
  v1::WatchMapRequest request;
  if (absl::Status status = ReadMessage(message, &request); !status.ok()) return status;
  if (request.level() > kMaxTileLevel) {
    return absl::InvalidArgumentError(
        absl::StrCat("no map has a level ", request.level(), ": give ", kMaxTileLevel, " at most"));
  }
  known_ = {request.run(), request.from_revision()};
  level_ = request.level();
  // Before the map is looked at, so that nothing is missed in between.
  const auto wake = [this, weak = weak_from_this()] {
    const auto self = weak.lock();
    if (self == nullptr || is_woken_.exchange(true)) return;
    Post([this] {
      is_woken_ = false;
      has_news_ = true;
      SendNext();
    });
  };
  handle_ = call().pipeline().feed().OnChange(wake);
  return absl::OkStatus();
}

void MapStream::OnMessage(grpc::ByteBuffer message) {
  if (absl::Status status = BeginWatch(&message); !status.ok()) return End(status);
  SendNext();
}

std::optional<v1::WatchMapResponse> MapStream::NextPart() {
  if (!parts_ && has_news_) {
    has_news_ = false;
    std::optional<MapStep> step = call().pipeline().feed().Since(known_, level_);
    const bool is_new =
        step && (step->restart || !has_written_ || step->mark.revision != known_.revision);
    if (is_new) {
      known_ = step->mark;
      parts_.emplace(*std::move(step));
    }
  }
  if (!parts_) return std::nullopt;
  v1::WatchMapResponse part = parts_->Next();
  if (!part.more()) parts_.reset();
  return part;
}

std::optional<v1::WatchMapResponse> MapStream::NextRobots() {
  if (!are_robots_due_ || !has_written_) return std::nullopt;
  are_robots_due_ = false;
  robots_timer_.Arm(kRobotsInterval);
  v1::WatchMapResponse response;
  for (const RobotPlace& place : call().pipeline().RobotPlaces()) {
    *response.add_robots() = convert::ToMessage(place);
  }
  const std::string robots = response.SerializeAsString();
  if (std::exchange(robots_, robots) == robots) return std::nullopt;
  response.set_has_robots(true);
  response.set_revision(known_.revision);
  response.set_run(known_.run);
  return response;
}

void MapStream::SendNext() {
  if (is_writing_ || ended()) return;
  std::optional<v1::WatchMapResponse> response = NextPart();
  if (!response) response = NextRobots();
  if (!response) return;
  is_writing_ = has_written_ = true;
  response_ = ToBytes(*response);
  GiveTime(host().options.progress,
           absl::DeadlineExceededError(
               "the client did not read for too long: ask again with the last revision that came"));
  StartWrite(&response_);
}

void MapStream::OnWriteDone(bool ok) {
  Post([this, ok] {
    TakeNoTime();
    is_writing_ = false;
    if (!ok) return End(absl::CancelledError("the client went away"));
    response_.Clear();
    SendNext();
  });
}

void MapStream::OnEnd() {
  robots_timer_.Disarm();
  if (handle_) call().pipeline().feed().Forget(*handle_);
}

}  // namespace isthmus::rpc
