// Points of the merged map: which, and how they are sent.
#include <absl/container/flat_hash_set.h>
#include <absl/strings/str_cat.h>

#include <algorithm>
#include <bit>
#include <limits>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "api/convert/cloud.h"
#include "api/convert/map.h"
#include "core/codec/draco_cloud.h"
#include "core/codec/quantized.h"
#include "core/content_hash.h"
#include "core/nanoseconds.h"
#include "core/records/region_of.h"
#include "server/map/map_view.h"
#include "server/rpc/map_answers.h"
#include "server/rpc/responses.h"

namespace isthmus::rpc {
namespace {

// Whole seconds, as points have them.
uint32_t SecondsOf(int64_t ns) {
  constexpr int64_t kMost = std::numeric_limits<uint32_t>::max();
  return static_cast<uint32_t>(std::clamp<int64_t>(ns / kNsPerSecond, 0, kMost));
}

Region WholeRegionOf(const RegionQuery& query, uint32_t component) {
  Region region = RegionOf(query, component);
  region.resolution_m = query.resolution_m;
  region.classes = PointClasses(query.classes);
  if (query.seen_from_ns != 0) region.seen_from = SecondsOf(query.seen_from_ns);
  if (query.seen_to_ns != 0) region.seen_to = SecondsOf(query.seen_to_ns);
  return region;
}

// Tells positions in the answer to this very request at that resolution, in this run of the server;
// of a revision there is more than one map while submaps wait for their turn.
uint64_t RunOf(uint64_t run, const ComposedMap& map, v1::QueryRegionRequest request,
               double resolution_m) {
  request.clear_resume();
  ContentHash hash;
  hash.Add(run);
  hash.Add(map.waiting_submaps());
  hash.Add(std::bit_cast<uint64_t>(resolution_m));
  hash.AddText(request.SerializeAsString());
  return hash.value();
}

// Sets region.robot. Returns false for a robot that is known but has no points in this map yet.
absl::StatusOr<bool> FindRobot(const server::MapView& view, const RobotId& robot, Region& region) {
  if (robot.empty()) return true;
  std::vector<SessionId> sessions;
  for (const auto& [id, session] : view.sessions) {
    if (session.record.robot == robot) sessions.push_back(id);
  }
  const ComposedMap& map = *view.map;
  const absl::Status is_here =
      CheckRobotIsIn(region.component, robot, sessions,
                     [&map](const SessionId& session) { return map.component_of(session); });
  if (!is_here.ok()) return is_here;
  const auto& placed = map.robots();
  const auto found = std::find(placed.begin(), placed.end(), robot);
  region.robot = static_cast<int>(found - placed.begin());
  if (found != placed.end()) return true;
  if (!sessions.empty()) return false;
  return absl::NotFoundError(absl::StrCat("no robot \"", robot.value(), "\" in this map"));
}

// A point says who saw it last and when, which is a submap's time. Of the sessions wanted all
// segments count.
absl::StatusOr<std::function<bool(const MapPoint&)>> SeenBy(const server::MapView& view,
                                                            const std::vector<SessionId>& wanted) {
  const std::vector<RobotId>& robots = view.map->robots();
  const auto key = [](uint64_t robot, uint32_t stamp) { return robot << 32 | stamp; };
  auto seen = std::make_shared<absl::flat_hash_set<uint64_t>>();
  std::set<SessionId> missing(wanted.begin(), wanted.end());
  for (const auto& [id, session] : view.sessions) {
    bool is_wanted = false;
    for (const SessionId& name : wanted) {
      if (name != id && name != session.record.opened()) continue;
      is_wanted = true;
      missing.erase(name);
    }
    const auto robot = std::find(robots.begin(), robots.end(), session.record.robot);
    if (!is_wanted || robot == robots.end()) continue;
    const auto number = static_cast<uint64_t>(robot - robots.begin());
    for (const auto& [index, submap] : session.submaps) {
      seen->insert(key(number, SecondsOf(submap.last_stamp_ns)));
    }
  }
  if (!missing.empty()) {
    return absl::NotFoundError(absl::StrCat("no session \"", missing.begin()->value(),
                                            "\"; `isthmus session list` shows all sessions"));
  }
  return [seen, key](const MapPoint& p) { return seen->contains(key(p.robot, p.stamp)); };
}

// True if the region has more points than that. They are counted only where the map does not know.
absl::StatusOr<bool> HasMore(const ComposedMap& map, const Region& region, uint64_t max_points) {
  const PointBounds bounds = map.BoundsOf(region);
  if (bounds.least > max_points || bounds.most <= max_points) return bounds.least > max_points;
  uint64_t count = 0;
  const absl::Status status =
      map.Read(region, kResponsePoints, [&](const std::vector<MapPoint>& points) {
        count += points.size();
        return count <= max_points;
      });
  if (!status.ok()) return status;
  return count > max_points;
}

// The finest resolution with which the region has at most so many points; where none has, the
// coarsest that was tried.
absl::StatusOr<double> FindResolution(const ComposedMap& map, Region region, uint64_t max_points) {
  const Box bounds = map.bounds(region.component);
  const double extent = bounds.empty() ? 0 : (bounds.max - bounds.min).maxCoeff();
  constexpr double kFinestM = 0.01;  // Used if the map does not say.
  while (true) {
    const absl::StatusOr<bool> has_more = HasMore(map, region, max_points);
    if (!has_more.ok()) return has_more.status();
    if (!*has_more || region.resolution_m > extent) return region.resolution_m;
    if (region.keep_on && !region.keep_on()) return region.resolution_m;  // The client is gone.
    region.resolution_m =
        region.resolution_m > 0 ? 2 * region.resolution_m : std::max(map.voxel_m(), kFinestM);
  }
}

// Puts points into responses.
class RegionSender {
 public:
  using Writer = grpc::ServerWriter<v1::QueryRegionResponse>;

  RegionSender(const RegionQuery& query, const RegionPosition& begin, Writer* writer)
      : query_(query), next_(begin), writer_(*writer) {}

  bool SendHead(const std::vector<RobotId>& robots) {
    for (const RobotId& robot : robots) response_.add_robots(robot.value());
    const bool sent = Send({});
    response_.clear_robots();
    return sent;
  }
  // False once no more can be sent, or need be; see `status`.
  bool Send(const std::vector<MapPoint>& points) {
    PointPayload payload = convert::ToPayload(points, {query_.wants_intensity, query_.wants_robot,
                                                       query_.wants_stamp, query_.wants_label});
    if (query_.rounding_m && !points.empty()) {
      auto rounded = query_.with_draco ? codec::PackDraco(payload, *query_.rounding_m)
                                       : codec::Quantize(payload, *query_.rounding_m);
      if (!rounded.ok()) status_ = rounded.status();
      if (!status_.ok()) return false;
      payload = *std::move(rounded);
    }
    *response_.mutable_cloud() = convert::ToMessage(std::move(payload));
    next_.points += points.size();
    response_.set_revision(next_.revision);
    response_.set_resolution_m(next_.resolution_m);
    *response_.mutable_next() = convert::ToMessage(next_);
    if (!writer_.Write(response_)) status_ = ReaderGone();
    return status_.ok();
  }
  // At most as many as are asked for.
  bool SendSome(std::vector<MapPoint> points) {
    const uint64_t most =
        query_.max_points == 0 ? std::numeric_limits<uint64_t>::max() : query_.max_points;
    const uint64_t left = most - std::min(most, next_.points);
    if (points.size() > left) points.resize(left);
    return points.empty() ? false : Send(points);
  }
  const absl::Status& status() const { return status_; }

 private:
  const RegionQuery& query_;
  RegionPosition next_;
  Writer& writer_;
  v1::QueryRegionResponse response_;
  absl::Status status_;
};

}  // namespace

absl::Status SendRegion(const Call& call, const v1::QueryRegionRequest& request,
                        uint64_t run_of_server,
                        grpc::ServerWriter<v1::QueryRegionResponse>* writer) {
  const auto query = convert::FromMessage(request);
  if (!query.ok()) return query.status();
  const std::shared_ptr<const server::MapView> view = call.pipeline().reader().View();
  const std::shared_ptr<const ComposedMap>& map = view->map;
  if (absl::Status ready = map->ready(); !ready.ok()) return ready;
  const auto number = map->NumberOf(query->component);
  if (!number.ok()) return number.status();
  Region region = WholeRegionOf(*query, *number);
  const absl::StatusOr<bool> has_points = FindRobot(*view, query->robot, region);
  if (!has_points.ok()) return has_points.status();
  if (!query->sessions.empty()) {
    auto keep = SeenBy(*view, query->sessions);
    if (!keep.ok()) return keep.status();
    region.keep = *std::move(keep);
  }
  const auto goes_on = [&] { return call.Allowed().ok() && !call.Gone(); };
  region.keep_on = goes_on;
  RegionPosition begin{0, map->revision(), 0, region.resolution_m};
  if (query->resume) {
    const uint64_t run = RunOf(run_of_server, *map, request, query->resume->resolution_m);
    if (query->resume->run != run || query->resume->revision != begin.revision) {
      return absl::FailedPreconditionError(
          absl::StrCat("resume is of another request, or the map is another by now, of revision ",
                       map->revision(), ": ask for the region anew, without resume"));
    }
    begin = *query->resume;
    region.resolution_m = begin.resolution_m;
    region.skip = begin.points;
  } else if (query->max_points > 0 && *has_points) {
    const auto resolution = FindResolution(*map, region, query->max_points);
    if (!resolution.ok()) return resolution.status();
    begin.resolution_m = region.resolution_m = *resolution;
  }
  if (!query->resume) begin.run = RunOf(run_of_server, *map, request, begin.resolution_m);
  RegionSender sender(*query, begin, writer);
  if (!goes_on() || !sender.SendHead(map->robots())) return ReaderGone();
  absl::Status status;
  if (*has_points) {
    status = map->Read(region, kResponsePoints, [&](const std::vector<MapPoint>& points) {
      return goes_on() && sender.SendSome(points);
    });
  }
  if (!sender.status().ok()) return sender.status();
  return goes_on() ? status : ReaderGone();
}

}  // namespace isthmus::rpc
