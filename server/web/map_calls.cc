#include "server/web/map_calls.h"

#include <utility>

#include "api/convert/geometry.h"
#include "api/convert/graph.h"
#include "api/convert/map.h"
#include "api/convert/map_name.h"
#include "api/convert/session.h"
#include "core/records/map_tracks.h"
#include "isthmus/v1/session_service.pb.h"
#include "server/web/limits.h"
#include "server/web/rpc_call.h"

namespace isthmus::web {

template <typename Answer>
absl::Status MapCalls::Call(const std::string& method, const google::protobuf::MessageLite& message,
                            const std::function<bool(const Answer&)>& take) const {
  RpcCall::Request asked = RpcCall::For(request_, method, message.SerializeAsString());
  asked.deadline = kCallTime;
  RpcCall call(channel_, std::move(asked));
  std::string bytes;
  Answer answer;
  while (call.Take({}, &bytes) == RpcCall::Next::kMessage) {
    if (!answer.ParseFromString(bytes)) return absl::InternalError(method + ": no such answer");
    if (!take(answer)) return absl::OkStatus();
  }
  return call.status();
}

absl::StatusOr<RobotTrajectory> MapCalls::GetTrajectory(const std::string& robot, v1::Frame frame,
                                                        uint32_t segment) const {
  v1::GetTrajectoryRequest wanted;
  wanted.set_robot(robot);
  wanted.set_frame(frame);
  wanted.set_segment(segment);
  RobotTrajectory way;
  const absl::Status status = Call<v1::GetTrajectoryResponse>(
      "MapService/GetTrajectory", wanted, [&way](const v1::GetTrajectoryResponse& part) {
        way.session = SessionId(part.session());
        way.revision = part.revision();
        for (const v1::StampedPose& pose : part.poses()) {
          way.poses.push_back(convert::FromMessage(pose));
        }
        return true;
      });
  if (!status.ok()) return status;
  return way;
}

absl::StatusOr<std::vector<SessionRecord>> MapCalls::ListSessions() const {
  std::vector<SessionRecord> sessions;
  const absl::Status status =
      Call<v1::ListSessionsResponse>("SessionService/ListSessions", v1::ListSessionsRequest(),
                                     [&sessions](const v1::ListSessionsResponse& part) {
                                       for (const v1::Session& session : part.sessions()) {
                                         sessions.push_back(convert::FromMessage(session).record);
                                       }
                                       return true;
                                     });
  if (!status.ok()) return status;
  return sessions;
}

absl::StatusOr<std::vector<Track>> MapCalls::GetTracks(MapInfo info, const MapName& map) const {
  const TrackSource source = {[this] { return GetMapInfo(); }, [this] { return ListSessions(); },
                              [this](const SessionId& opened, uint32_t segment) {
                                return GetTrajectory(opened.value(), v1::MAP, segment);
                              }};
  return ReadTracks(source, std::move(info), map);
}

absl::StatusOr<MapInfo> MapCalls::GetMapInfo() const {
  MapInfo info;
  const absl::Status status = Call<v1::MapInfo>("MapService/GetMapInfo", v1::GetMapInfoRequest(),
                                                [&info](const v1::MapInfo& told) {
                                                  info = convert::FromMessage(told);
                                                  return true;
                                                });
  if (!status.ok()) return status;
  return info;
}

absl::StatusOr<v1::ServerStatus> MapCalls::GetStatus() const {
  v1::ServerStatus status;
  const absl::Status asked = Call<v1::ServerStatus>(
      "AdminService/GetStatus", v1::GetStatusRequest(), [&status](const v1::ServerStatus& told) {
        status = told;
        return true;
      });
  if (!asked.ok()) return asked;
  return status;
}

absl::StatusOr<std::vector<RobotAnchor>> MapCalls::ListAnchors() const {
  std::vector<RobotAnchor> anchors;
  const absl::Status status =
      Call<v1::ListAnchorsResponse>("MapService/ListAnchors", v1::ListAnchorsRequest(),
                                    [&anchors](const v1::ListAnchorsResponse& part) {
                                      for (const v1::Anchor& anchor : part.anchors()) {
                                        anchors.push_back(convert::FromMessage(anchor));
                                      }
                                      return true;
                                    });
  if (!status.ok()) return status;
  return anchors;
}

absl::StatusOr<MapCalls::TileList> MapCalls::ListTiles(const MapName& map) const {
  v1::ListTilesRequest wanted;
  convert::PutMap(map, wanted);
  TileList list;
  const absl::Status status = Call<v1::ListTilesResponse>(
      "MapService/ListTiles", wanted, [&list](const v1::ListTilesResponse& part) {
        list.revision = part.revision();
        list.tile_m = part.tile_m();
        for (const v1::TileInfo& tile : part.tiles()) list.tiles.push_back(tile.id());
        return true;
      });
  if (!status.ok()) return status;
  return list;
}

absl::StatusOr<std::string> MapCalls::ExportMap(const v1::ExportMapRequest& wanted,
                                                size_t max_bytes) const {
  std::string file;
  const absl::Status status = Call<v1::ExportMapResponse>("MapService/ExportMap", wanted,
                                                          [&](const v1::ExportMapResponse& part) {
                                                            file += part.data();
                                                            return file.size() <= max_bytes;
                                                          });
  if (!status.ok()) return status;
  if (file.size() <= max_bytes) return file;
  return absl::ResourceExhaustedError(
      "that much of the map at once is too large here: give a coarser ?resolution= or a ?box=");
}

}  // namespace isthmus::web
