// The part of Client that reads how the map hangs together, and how it came to be so.
#include <algorithm>
#include <cstdint>

#include "api/convert/changed_volumes.h"
#include "api/convert/graph.h"
#include "client/library/client.h"
#include "client/library/list_stream.h"

namespace isthmus::client {

using Stubs = Client::Link::Stubs;

namespace {

void AddMatches(const v1::GetMatchGraphResponse& part, MatchGraph& graph) {
  graph.revision = part.revision();
  for (const v1::SubmapEdge& edge : part.more_edges()) {
    if (!graph.matches.empty()) {
      graph.matches.back().match.edges.push_back(convert::FromMessage(edge));
    }
  }
  for (const v1::Match& match : part.matches()) {
    graph.matches.push_back(convert::FromMessage(match));
  }
  for (const v1::Placement& placement : part.placements()) {
    graph.placements.push_back(convert::FromMessage(placement));
  }
}

void AddLoops(const v1::ListLoopsResponse& part, ListAt<Loop>& loops) {
  loops.revision = part.revision();
  for (const v1::SubmapEdge& edge : part.more_edges()) {
    if (!loops.empty()) loops.back().loop.edges.push_back(convert::FromMessage(edge));
  }
  for (const v1::Loop& loop : part.loops()) loops.push_back(convert::FromMessage(loop));
}

void AddAnchors(const v1::ListAnchorsResponse& part, ListAt<RobotAnchor>& anchors) {
  anchors.revision = part.revision();
  for (const v1::Anchor& anchor : part.anchors()) anchors.push_back(convert::FromMessage(anchor));
}

void AddRevisions(const v1::ListRevisionsResponse& part, std::vector<RevisionInfo>& revisions) {
  for (const v1::Revision& revision : part.revisions()) {
    revisions.push_back(convert::FromMessage(revision));
  }
}

void AddMoves(const v1::DiffRevisionsResponse& part, RevisionDiff& diff) {
  diff.from = part.from_revision();
  diff.to = part.to_revision();
  for (const v1::Revision& revision : part.revisions()) {
    diff.revisions.push_back(convert::FromMessage(revision));
  }
  for (const v1::SubmapMove& move : part.moves()) {
    diff.moves.push_back(convert::FromMessage(move));
  }
}

void AddChanges(const v1::FindChangesResponse& part, ChangeList& list) {
  list.revision = part.revision();
  list.submaps_before = part.submaps_before();
  list.submaps_after = part.submaps_after();
  list.left_out = part.left_out();
  for (const v1::ChangedVolume& volume : part.volumes()) {
    list.volumes.push_back(convert::FromMessage(volume));
  }
}

}  // namespace

absl::StatusOr<MatchGraph> Client::GetMatchGraph(bool include_edges) {
  v1::GetMatchGraphRequest request;
  request.set_include_edges(include_edges);
  const auto open = [&](Stubs& stubs, grpc::ClientContext& context) {
    return stubs.maps->GetMatchGraph(&context, request);
  };
  return ReadList(*link_, open, AddMatches);
}

absl::StatusOr<ListAt<Loop>> Client::ListLoops(const RobotId& robot, bool include_edges) {
  v1::ListLoopsRequest request;
  request.set_robot(robot.value());
  request.set_include_edges(include_edges);
  const auto open = [&](Stubs& stubs, grpc::ClientContext& context) {
    return stubs.maps->ListLoops(&context, request);
  };
  return ReadList(*link_, open, AddLoops);
}

absl::StatusOr<ListAt<RobotAnchor>> Client::ListAnchors() {
  const auto open = [](Stubs& stubs, grpc::ClientContext& context) {
    return stubs.maps->ListAnchors(&context, v1::ListAnchorsRequest());
  };
  return ReadList(*link_, open, AddAnchors);
}

absl::StatusOr<std::vector<RevisionInfo>> Client::ListRevisions(int limit) {
  v1::ListRevisionsRequest request;
  request.set_limit(static_cast<uint32_t>(std::max(limit, 0)));
  const auto open = [&](Stubs& stubs, grpc::ClientContext& context) {
    return stubs.maps->ListRevisions(&context, request);
  };
  return ReadList(*link_, open, AddRevisions);
}

absl::StatusOr<RevisionDiff> Client::DiffRevisions(int64_t from, int64_t to) {
  v1::DiffRevisionsRequest request;
  request.set_from_revision(from);
  request.set_to_revision(to);
  const auto open = [&](Stubs& stubs, grpc::ClientContext& context) {
    return stubs.maps->DiffRevisions(&context, request);
  };
  return ReadList(*link_, open, AddMoves);
}

absl::StatusOr<ChangeList> Client::FindChanges(const ChangeQuery& query) {
  const v1::FindChangesRequest request = convert::ToMessage(query);
  const auto open = [&](Stubs& stubs, grpc::ClientContext& context) {
    return stubs.maps->FindChanges(&context, request);
  };
  return ReadList(*link_, open, AddChanges);
}

}  // namespace isthmus::client
