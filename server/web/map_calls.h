// Calls of this server's own services that one answer is made of, in the name of its caller.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>
#include <google/protobuf/message_lite.h>
#include <grpcpp/channel.h>

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/map/map_name.h"
#include "core/map/session.h"
#include "core/map/track.h"
#include "core/records/map_graph.h"
#include "core/records/map_info.h"
#include "core/records/map_reading.h"
#include "isthmus/v1/admin_service.pb.h"
#include "isthmus/v1/map_service.pb.h"
#include "server/http/exchange.h"

namespace isthmus::web {

// Thread safe; the request must outlive it.
class MapCalls {
 public:
  MapCalls(const http::Request& request, std::shared_ptr<grpc::Channel> channel)
      : request_(request), channel_(std::move(channel)) {}

  // Session, revision and poses of a robot's newest session, or of the session of that id; in its
  // odom or the map frame. Segment and errors as of MapService.GetTrajectory.
  absl::StatusOr<RobotTrajectory> GetTrajectory(const std::string& robot, v1::Frame frame,
                                                uint32_t segment = 0) const;
  // The ways of all sessions that lie in the map: isthmus::ReadTracks.
  absl::StatusOr<std::vector<Track>> GetTracks(MapInfo info, const MapName& map) const;
  absl::StatusOr<MapInfo> GetMapInfo() const;
  absl::StatusOr<v1::ServerStatus> GetStatus() const;
  absl::StatusOr<std::vector<RobotAnchor>> ListAnchors() const;
  struct TileList {
    int64_t revision = 0;  // Revision of the composed map, so of its files.
    double tile_m = 0;
    std::vector<v1::TileId> tiles;
  };
  // The tiles of level 0.
  absl::StatusOr<TileList> ListTiles(const MapName& map) const;
  // All bytes at once; ResourceExhausted where there are more than `max_bytes`.
  absl::StatusOr<std::string> ExportMap(const v1::ExportMapRequest& wanted, size_t max_bytes) const;

 private:
  // In order of creation, segments among them.
  absl::StatusOr<std::vector<SessionRecord>> ListSessions() const;
  // Gives every answer to `take`, until it returns false, which is no error.
  template <typename Answer>
  absl::Status Call(const std::string& method, const google::protobuf::MessageLite& message,
                    const std::function<bool(const Answer&)>& take) const;

  const http::Request& request_;
  const std::shared_ptr<grpc::Channel> channel_;
};

}  // namespace isthmus::web
