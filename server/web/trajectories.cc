#include "server/web/trajectories.h"

#include <absl/strings/strip.h>

#include <string>

#include "core/formats/tum.h"
#include "server/web/answers.h"
#include "server/web/map_calls.h"

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

}  // namespace isthmus::web
