// Reading the map. api/isthmus/v1/map_service.proto says what each method returns and fails with.
#include <algorithm>
#include <optional>
#include <random>
#include <string>

#include "api/convert/geometry.h"
#include "api/convert/graph.h"
#include "api/convert/map.h"
#include "isthmus/v1/map_service.grpc.pb.h"
#include "server/rpc/map_answers.h"
#include "server/rpc/map_stream.h"
#include "server/rpc/responses.h"
#include "server/rpc/services.h"

namespace isthmus::rpc {
namespace {

constexpr uint32_t kDefaultRevisions = 100, kMaxRevisions = 10'000;  // As the API says.

// Nothing for an empty name: all robots.
std::optional<RobotId> Wanted(const std::string& robot) {
  return robot.empty() ? std::nullopt : std::optional(RobotId(robot));
}

absl::Status SendTrajectory(const Call& call, const RobotTrajectory& trajectory,
                            grpc::ServerWriter<v1::GetTrajectoryResponse>* writer) {
  v1::GetTrajectoryResponse head;
  head.set_revision(trajectory.revision);
  head.set_session(trajectory.session.value());
  head.set_component(trajectory.component);
  for (const uint32_t segment : trajectory.left_out) head.add_segments_left_out(segment);
  size_t sent = 0;
  for (const RobotTrajectory::Part& part : trajectory.parts) {
    head.set_segment(part.segment);  // Named also where there are no poses.
    ListEmitter<v1::GetTrajectoryResponse> list(call, head, writer);
    for (const size_t end = sent + part.count; sent < end; ++sent) {
      list.Add(&v1::GetTrajectoryResponse::mutable_poses,
               convert::ToMessage(trajectory.poses[sent]));
    }
    if (absl::Status status = list.Finish(); !status.ok()) return status;
  }
  return absl::OkStatus();
}

// A client can watch without end: that holds no thread.
using MapServiceBase = v1::MapService::WithRawCallbackMethod_WatchMap<v1::MapService::Service>;

class MapService final : public MapServiceBase {
 public:
  explicit MapService(const ServiceParts& parts)
      : gate_(parts.gate), host_(parts.host), run_(uint64_t{std::random_device()()} << 32 | 1) {}

  grpc::Status GetMapInfo(grpc::ServerContext* context, const v1::GetMapInfoRequest* request,
                          v1::MapInfo* response) override {
    return gate_.Serve(context, *request, "GetMapInfo", [&](const Call& call) -> absl::Status {
      *response = convert::ToMessage(call.pipeline().GetMapInfo());
      return absl::OkStatus();
    });
  }

  grpc::Status ListSubmaps(grpc::ServerContext* context, const v1::ListSubmapsRequest* request,
                           grpc::ServerWriter<v1::ListSubmapsResponse>* writer) override {
    return gate_.Serve(context, *request, "ListSubmaps", [&](const Call& call) -> absl::Status {
      const auto submaps = call.pipeline().reader().ListSubmaps(Wanted(request->robot()));
      if (!submaps.ok()) return submaps.status();
      v1::ListSubmapsResponse head;
      head.set_revision(submaps->revision);
      ListEmitter<v1::ListSubmapsResponse> list(call, head, writer);
      for (const SubmapStatus& submap : *submaps) {
        list.Add(&v1::ListSubmapsResponse::mutable_submaps, convert::ToMessage(submap));
      }
      return list.Finish();
    });
  }

  grpc::Status GetTrajectory(grpc::ServerContext* context, const v1::GetTrajectoryRequest* request,
                             grpc::ServerWriter<v1::GetTrajectoryResponse>* writer) override {
    return gate_.Serve(context, *request, "GetTrajectory", [&](const Call& call) -> absl::Status {
      const auto frame = convert::FromMessage(request->frame());
      if (!frame.ok()) return frame.status();
      const auto trajectory = call.pipeline().reader().GetTrajectory(RobotId(request->robot()),
                                                                     *frame, request->segment());
      if (!trajectory.ok()) return trajectory.status();
      return SendTrajectory(call, *trajectory, writer);
    });
  }

  grpc::Status GetMatchGraph(grpc::ServerContext* context, const v1::GetMatchGraphRequest* request,
                             grpc::ServerWriter<v1::GetMatchGraphResponse>* writer) override {
    return gate_.Serve(context, *request, "GetMatchGraph", [&](const Call& call) -> absl::Status {
      using Response = v1::GetMatchGraphResponse;
      const MatchGraph graph = call.pipeline().reader().GetMatchGraph();
      Response head;
      head.set_revision(graph.revision);
      ListEmitter<Response> list(call, head, writer);
      for (const MatchEdge& edge : graph.matches) {
        const std::vector<SubmapEdge> none;
        AddWithEdges(&Response::mutable_matches, convert::ToMessage(edge),
                     request->include_edges() ? edge.match.edges : none, &list);
      }
      for (const PlacedSession& placed : graph.placements) {
        list.Add(&Response::mutable_placements, convert::ToMessage(placed));
      }
      return list.Finish();
    });
  }

  grpc::Status ListLoops(grpc::ServerContext* context, const v1::ListLoopsRequest* request,
                         grpc::ServerWriter<v1::ListLoopsResponse>* writer) override {
    return gate_.Serve(context, *request, "ListLoops", [&](const Call& call) -> absl::Status {
      const auto loops = call.pipeline().reader().ListLoops(Wanted(request->robot()));
      if (!loops.ok()) return loops.status();
      v1::ListLoopsResponse head;
      head.set_revision(loops->revision);
      ListEmitter<v1::ListLoopsResponse> list(call, head, writer);
      for (const Loop& loop : *loops) {
        const std::vector<SubmapEdge> none;
        AddWithEdges(&v1::ListLoopsResponse::mutable_loops, convert::ToMessage(loop),
                     request->include_edges() ? loop.loop.edges : none, &list);
      }
      return list.Finish();
    });
  }

  grpc::Status ListAnchors(grpc::ServerContext* context, const v1::ListAnchorsRequest* request,
                           grpc::ServerWriter<v1::ListAnchorsResponse>* writer) override {
    return gate_.Serve(context, *request, "ListAnchors", [&](const Call& call) -> absl::Status {
      const server::MapReader& reader = call.pipeline().reader();
      const ListAt<RobotAnchor> anchors = reader.ListAnchors(*reader.View());
      v1::ListAnchorsResponse head;
      head.set_revision(anchors.revision);
      ListEmitter<v1::ListAnchorsResponse> list(call, head, writer);
      for (const RobotAnchor& anchor : anchors) {
        list.Add(&v1::ListAnchorsResponse::mutable_anchors, convert::ToMessage(anchor));
      }
      return list.Finish();
    });
  }

  grpc::Status ListRevisions(grpc::ServerContext* context, const v1::ListRevisionsRequest* request,
                             grpc::ServerWriter<v1::ListRevisionsResponse>* writer) override {
    return gate_.Serve(context, *request, "ListRevisions", [&](const Call& call) -> absl::Status {
      const uint32_t limit = request->limit() == 0 ? kDefaultRevisions : request->limit();
      const auto revisions =
          call.pipeline().reader().ListRevisions(static_cast<int>(std::min(limit, kMaxRevisions)));
      if (!revisions.ok()) return revisions.status();
      v1::ListRevisionsResponse head;
      // Taken from the list itself, so that the two cannot differ.
      if (!revisions->empty()) head.set_revision(revisions->front().revision);
      ListEmitter<v1::ListRevisionsResponse> list(call, head, writer);
      for (const RevisionInfo& info : *revisions) {
        list.Add(&v1::ListRevisionsResponse::mutable_revisions, convert::ToMessage(info));
      }
      return list.Finish();
    });
  }

  grpc::Status DiffRevisions(grpc::ServerContext* context, const v1::DiffRevisionsRequest* request,
                             grpc::ServerWriter<v1::DiffRevisionsResponse>* writer) override {
    return gate_.Serve(context, *request, "DiffRevisions", [&](const Call& call) -> absl::Status {
      if (request->from_revision() < 0 || request->to_revision() < 0) {
        return absl::InvalidArgumentError("revisions are counted from 0, the empty map");
      }
      const auto diff =
          call.pipeline().reader().DiffRevisions(request->from_revision(), request->to_revision());
      if (!diff.ok()) return diff.status();
      v1::DiffRevisionsResponse head;
      head.set_from_revision(diff->from);
      head.set_to_revision(diff->to);
      ListEmitter<v1::DiffRevisionsResponse> list(call, head, writer);
      for (const RevisionInfo& info : diff->revisions) {
        list.Add(&v1::DiffRevisionsResponse::mutable_revisions, convert::ToMessage(info));
      }
      for (const SubmapMove& move : diff->moves) {
        list.Add(&v1::DiffRevisionsResponse::mutable_moves, convert::ToMessage(move));
      }
      return list.Finish();
    });
  }

  grpc::Status GetTransform(grpc::ServerContext* context, const v1::GetTransformRequest* request,
                            v1::GetTransformResponse* response) override {
    return gate_.Serve(context, *request, "GetTransform", [&](const Call& call) -> absl::Status {
      const auto transform = call.pipeline().reader().GetTransform(RobotId(request->robot_a()),
                                                                   RobotId(request->robot_b()));
      if (transform.ok()) {
        response->set_revision(transform->revision);
        *response->mutable_t_a_b() = convert::ToMessage(transform->T_a_b);
      }
      return transform.status();
    });
  }

  grpc::Status QueryRegion(grpc::ServerContext* context, const v1::QueryRegionRequest* request,
                           grpc::ServerWriter<v1::QueryRegionResponse>* writer) override {
    return gate_.Serve(context, *request, "QueryRegion",
                       [&](const Call& call) { return SendRegion(call, *request, run_, writer); });
  }

  grpc::Status FindChanges(grpc::ServerContext* context, const v1::FindChangesRequest* request,
                           grpc::ServerWriter<v1::FindChangesResponse>* writer) override {
    return gate_.Serve(context, *request, "FindChanges",
                       [&](const Call& call) { return SendChanges(call, *request, writer); });
  }

  grpc::Status ExportMap(grpc::ServerContext* context, const v1::ExportMapRequest* request,
                         grpc::ServerWriter<v1::ExportMapResponse>* writer) override {
    return gate_.Serve(context, *request, "ExportMap",
                       [&](const Call& call) { return SendMap(call, *request, writer); });
  }

  grpc::Status ExportPoseGraph(grpc::ServerContext* context,
                               const v1::ExportPoseGraphRequest* request,
                               grpc::ServerWriter<v1::ExportPoseGraphResponse>* writer) override {
    return gate_.Serve(context, *request, "ExportPoseGraph",
                       [&](const Call& call) { return SendPoseGraph(call, *request, writer); });
  }

  grpc::Status ListTiles(grpc::ServerContext* context, const v1::ListTilesRequest* request,
                         grpc::ServerWriter<v1::ListTilesResponse>* writer) override {
    return gate_.Serve(context, *request, "ListTiles",
                       [&](const Call& call) { return SendTiles(call, *request, writer); });
  }

  grpc::Status GetTile(grpc::ServerContext* context, const v1::GetTileRequest* request,
                       grpc::ServerWriter<v1::GetTileResponse>* writer) override {
    return gate_.Serve(context, *request, "GetTile",
                       [&](const Call& call) { return SendTile(call, *request, writer); });
  }

  grpc::ServerWriteReactor<grpc::ByteBuffer>* WatchMap(grpc::CallbackServerContext* context,
                                                       const grpc::ByteBuffer* request) override {
    return MapStreamBase::Begin<MapStream>(&host_, context, request);
  }

 private:
  Gate& gate_;
  StreamHost& host_;
  const uint64_t run_;  // This server's: positions of another one mean nothing here.
};

}  // namespace

std::unique_ptr<grpc::Service> MakeMapService(const ServiceParts& parts) {
  return std::make_unique<MapService>(parts);
}

}  // namespace isthmus::rpc
