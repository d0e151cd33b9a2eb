#include "api/convert/changed_volumes.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <string>
#include <utility>

#include "api/convert/geometry.h"
#include "api/convert/map_name.h"
#include "api/convert/region_place.h"

namespace isthmus::convert {
namespace {

constexpr uint32_t kMaxVolumes = 10'000;  // As the API says.

}  // namespace

v1::FindChangesRequest ToMessage(const ChangeQuery& query) {
  v1::FindChangesRequest message;
  if (query.since_ns) message.set_since_ns(*query.since_ns);
  if (query.since_revision) message.set_since_revision(*query.since_revision);
  PutMap(query.component, message);
  PutPlace(query, message);
  message.set_smallest_m(query.smallest_m);
  message.set_max_volumes(query.max_volumes);
  message.set_include_points(query.wants_points);
  return message;
}

absl::StatusOr<ChangeQuery> FromMessage(const v1::FindChangesRequest& request) {
  ChangeQuery query;
  switch (request.since_case()) {
    case v1::FindChangesRequest::kSinceNs:
      query.since_ns = request.since_ns();
      break;
    case v1::FindChangesRequest::kSinceRevision:
      query.since_revision = request.since_revision();
      break;
    default:
      return absl::InvalidArgumentError("say since when: give since_ns or since_revision");
  }
  if (query.since_revision && *query.since_revision < 0) {
    return absl::InvalidArgumentError("revisions are counted from 0, the empty map");
  }
  if (absl::Status status = TakePlace(request, query); !status.ok()) return status;
  query.component = MapOf(request);
  // Written so that NaN fails too.
  if (!(request.smallest_m() >= 0 && request.smallest_m() <= kMaxCoordinateM)) {
    return absl::InvalidArgumentError(absl::StrCat("smallest_m is ", request.smallest_m(),
                                                   ": give at most ", kMaxCoordinateM,
                                                   " m; 0 is 0.3 m"));
  }
  if (request.smallest_m() > 0) query.smallest_m = request.smallest_m();
  if (request.max_volumes() > 0) query.max_volumes = std::min(request.max_volumes(), kMaxVolumes);
  query.wants_points = request.include_points();
  return query;
}

v1::ChangedVolume ToMessage(const ChangedVolume& volume) {
  v1::ChangedVolume message;
  message.set_kind(volume.came ? v1::ChangedVolume::CAME : v1::ChangedVolume::WENT);
  *message.mutable_box()->mutable_t_map_box() = ToMessage(volume.T_map_box);
  *message.mutable_box()->mutable_size() = ToMessage(volume.size);
  message.set_points(volume.points);
  message.set_probability(volume.probability);
  message.set_seen_first_ns(volume.seen_first_ns);
  message.set_seen_last_ns(volume.seen_last_ns);
  message.set_missing_ns(volume.missing_ns);
  for (const RobotId& robot : volume.seen_by) message.add_seen_by(robot.value());
  for (const RobotId& robot : volume.missed_by) message.add_missed_by(robot.value());
  for (const Eigen::Vector3f& place : volume.places) {
    for (const float coordinate : {place.x(), place.y(), place.z()}) {
      message.add_places(coordinate);
    }
  }
  return message;
}

ChangedVolume FromMessage(const v1::ChangedVolume& message) {
  ChangedVolume volume;
  volume.came = message.kind() == v1::ChangedVolume::CAME;
  volume.T_map_box = FromMessage(message.box().t_map_box());
  volume.size = FromMessage(message.box().size());
  volume.points = message.points();
  volume.probability = message.probability();
  volume.seen_first_ns = message.seen_first_ns();
  volume.seen_last_ns = message.seen_last_ns();
  volume.missing_ns = message.missing_ns();
  for (const std::string& robot : message.seen_by()) volume.seen_by.emplace_back(robot);
  for (const std::string& robot : message.missed_by()) volume.missed_by.emplace_back(robot);
  for (int i = 0; i + 2 < message.places_size(); i += 3) {
    volume.places.emplace_back(message.places(i), message.places(i + 1), message.places(i + 2));
  }
  return volume;
}

}  // namespace isthmus::convert
