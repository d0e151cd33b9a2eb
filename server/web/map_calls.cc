#include "server/web/map_calls.h"

#include <utility>

#include "api/convert/geometry.h"
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

absl::StatusOr<MapCalls::Way> MapCalls::GetTrajectory(const std::string& robot,
                                                      v1::Frame frame) const {
  v1::GetTrajectoryRequest wanted;
  wanted.set_robot(robot);
  wanted.set_frame(frame);
  Way way;
  const absl::Status status = Call<v1::GetTrajectoryResponse>(
      "MapService/GetTrajectory", wanted, [&way](const v1::GetTrajectoryResponse& part) {
        way.component = part.component();
        for (const v1::StampedPose& pose : part.poses()) {
          way.poses.push_back(convert::FromMessage(pose));
        }
        return true;
      });
  if (!status.ok()) return status;
  return way;
}

absl::StatusOr<std::vector<std::string>> MapCalls::ListSessions() const {
  std::vector<std::string> sessions;
  const absl::Status status =
      Call<v1::ListSessionsResponse>("SessionService/ListSessions", v1::ListSessionsRequest(),
                                     [&sessions](const v1::ListSessionsResponse& part) {
                                       for (const v1::Session& session : part.sessions()) {
                                         if (session.segment() <= 1)
                                           sessions.push_back(session.id());
                                       }
                                       return true;
                                     });
  if (!status.ok()) return status;
  return sessions;
}

absl::StatusOr<MapCalls::TileList> MapCalls::ListTiles(uint32_t component) const {
  v1::ListTilesRequest wanted;
  wanted.set_component(component);
  TileList list;
  const absl::Status status = Call<v1::ListTilesResponse>(
      "MapService/ListTiles", wanted, [&list](const v1::ListTilesResponse& part) {
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
