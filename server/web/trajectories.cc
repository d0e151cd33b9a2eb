#include "server/web/trajectories.h"

#include <absl/strings/strip.h>

#include <string>

#include "core/earth/map_site.h"
#include "core/earth/tracks.h"
#include "core/formats/tum.h"
#include "server/web/answers.h"
#include "server/web/map_calls.h"
#include "server/web/map_query.h"

namespace isthmus::web {

http::Response AnswerTrajectory(const http::Request& request,
                                const std::shared_ptr<grpc::Channel>& channel) {
  if (request.method != "GET") return WrongMethod("GET");
  absl::string_view name = request.path;
  if (!absl::ConsumePrefix(&name, "/trajectories/") || !absl::ConsumeSuffix(&name, ".tum") ||
      name.empty()) {
    return ErrorAnswer(
        absl::NotFoundError("the way of a session or robot is at /trajectories/NAME.tum"));
  }
  const std::string frame = request.Query("frame").value_or("map");
  if (frame != "map" && frame != "odom") {
    return ErrorAnswer(absl::InvalidArgumentError("?frame= is map or odom"));
  }
  const auto way = MapCalls(request, channel)
                       .GetTrajectory(std::string(name), frame == "map" ? v1::MAP : v1::ODOM);
  if (!way.ok()) return ErrorAnswer(way.status());
  return TextAnswer(formats::FormatTum(way->poses));
}

http::Response AnswerTrajectoriesGeoJson(const http::Request& request,
                                         const std::shared_ptr<grpc::Channel>& channel) {
  if (request.method != "GET") return WrongMethod("GET");
  const MapName map = ReadMapName(request);
  const MapCalls calls(request, channel);
  const auto info = calls.GetMapInfo();
  if (!info.ok()) return ErrorAnswer(info.status());
  const auto anchors = calls.ListAnchors();
  if (!anchors.ok()) return ErrorAnswer(anchors.status());
  const auto site = earth::SiteOf(*info, *anchors, map);
  if (!site.ok()) return ErrorAnswer(site.status());
  const auto tracks = calls.GetTracks(*info, map);
  if (!tracks.ok()) return ErrorAnswer(tracks.status());
  return FreshAnswer("application/geo+json", earth::FormatGeoJson(*tracks, *site));
}

}  // namespace isthmus::web
