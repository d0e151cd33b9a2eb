#include "server/web/trajectories.h"

#include <absl/strings/strip.h>

#include <memory>
#include <string>

#include "core/earth/map_site.h"
#include "core/earth/tracks.h"
#include "core/formats/tum.h"
#include "isthmus/v1/map_service.pb.h"
#include "server/web/answers.h"
#include "server/web/map_query.h"
#include "server/web/map_read.h"

namespace isthmus::web {

http::Response AnswerTrajectory(const http::Request& request, rpc::Gate& gate) {
  if (request.method != "GET") return WrongMethod("GET");
  absl::string_view name = request.path;
  if (!absl::ConsumePrefix(&name, "/trajectories/") || !absl::ConsumeSuffix(&name, ".tum") ||
      name.empty()) {
    return ErrorAnswer(
        absl::NotFoundError("the way of a session or robot is at /trajectories/NAME.tum"));
  }
  if (absl::Status known = CheckQuery(request, {"frame"}); !known.ok()) return ErrorAnswer(known);
  const std::string frame = request.Query("frame").value_or("map");
  if (frame != "map" && frame != "odom") {
    return ErrorAnswer(absl::InvalidArgumentError("?frame= is map or odom"));
  }
  v1::GetTrajectoryRequest asked;
  asked.set_robot(std::string(name));
  return ReadMap(gate, request, "GetTrajectory", asked,
                 [&](const rpc::Call& call) -> absl::StatusOr<http::Response> {
                   const server::MapReader& reader = call.pipeline().reader();
                   const auto way = reader.GetTrajectory(
                       *reader.View(), RobotId(asked.robot()),
                       frame == "map" ? TrajectoryFrame::kMap : TrajectoryFrame::kOdom, 0);
                   if (!way.ok()) return way.status();
                   return TextAnswer(formats::FormatTum(way->poses));
                 });
}

http::Response AnswerTrajectoriesGeoJson(const http::Request& request, rpc::Gate& gate) {
  if (request.method != "GET") return WrongMethod("GET");
  if (absl::Status known = CheckQuery(request, {"map", "component"}); !known.ok()) {
    return ErrorAnswer(known);
  }
  const MapName map = ReadMapName(request);
  return ReadMap(gate, request, "GetTrajectory", v1::GetMapInfoRequest(),
                 [&map](const rpc::Call& call) -> absl::StatusOr<http::Response> {
                   const server::MapReader& reader = call.pipeline().reader();
                   const std::shared_ptr<const server::MapView> view = reader.View();
                   const auto site =
                       earth::SiteOf(reader.Describe(*view), reader.ListAnchors(*view), map);
                   if (!site.ok()) return site.status();
                   const auto tracks = reader.GetTracks(*view, map);
                   if (!tracks.ok()) return tracks.status();
                   return FreshAnswer("application/geo+json", earth::FormatGeoJson(*tracks, *site));
                 });
}

}  // namespace isthmus::web
