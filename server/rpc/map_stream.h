// MapService.WatchMap; see api/isthmus/v1/map_service.proto.
#pragma once

#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/server_callback.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "core/records/map_changes.h"
#include "isthmus/v1/map_service.pb.h"
#include "server/rpc/streams/stream_reactor.h"
#include "server/rpc/streams/watch_base.h"

namespace isthmus::rpc {

// A step of a watch, cut into responses of bounded size.
class StepParts {
 public:
  explicit StepParts(MapStep step) : step_(std::move(step)) {}

  // The next one; after the one without `more` there is none.
  v1::WatchMapResponse Next();

 private:
  size_t size() const;
  void Add(size_t index, v1::WatchMapResponse* response) const;

  const MapStep step_;
  size_t at_ = 0;  // Among all that the step holds, list after list.
};

using MapStreamBase = StreamReactor<WatchBase>;

// Holds one response, and one step that is on its way, at most; what comes meanwhile is told in one
// step after it, from the newest map. While nothing happens it holds no thread.
class MapStream final : public MapStreamBase {
 public:
  MapStream(StreamHost* host, grpc::CallbackServerContext* context,
            const grpc::ByteBuffer* request);

  void OnWriteDone(bool ok) override;

 private:
  void OnMessage(grpc::ByteBuffer message) override;
  void OnReadsDone() override {}
  void OnEnd() override;

  absl::Status BeginWatch(grpc::ByteBuffer* message);
  // Sends what is due, if anything is.
  void SendNext();
  // The next part of the step under way, or the first of a new one, if there is any.
  std::optional<v1::WatchMapResponse> NextPart();
  // The robots' places, if they are due and not the same as told last.
  std::optional<v1::WatchMapResponse> NextRobots();

  MapMark known_;
  uint32_t level_ = 0;
  std::optional<uint64_t> handle_;
  std::atomic<bool> is_woken_ = false;  // SendNext is on its way.
  bool has_news_ = true;                // Perhaps, of the map.
  bool are_robots_due_ = true;
  bool is_writing_ = false, has_written_ = false;
  std::optional<StepParts> parts_;
  std::string robots_;  // As told last.
  grpc::ByteBuffer response_;
  Watchdog::Timer robots_timer_;  // Last: it fires into the rest.
};

}  // namespace isthmus::rpc
