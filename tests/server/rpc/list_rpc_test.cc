// Lists that are longer than a response, over a socket.
#include "tests/server/rpc/rpc_fixture.h"

namespace isthmus::rpc {
namespace {

// The limit of gRPC's clients unless told otherwise; the fixture's client has it.
constexpr size_t kGrpcLimit = 4 << 20;

MatchEdge MatchOf(const std::string& a, const std::string& b, uint32_t edges) {
  MatchEdge edge;
  edge.match.a = SessionId(a);
  edge.match.b = SessionId(b);
  edge.match.edges.resize(edges);
  for (uint32_t k = 0; k < edges; ++k) {
    edge.match.edges[k].submap_a = k;
    edge.match.edges[k].T_a_b = Pose(Eigen::Vector3d(1, 2, 3));
    edge.match.edges[k].information.setConstant(0.25);
  }
  return edge;
}

class ListRpcTest : public RpcTest {};

TEST_F(ListRpcTest, TenThousandSubmapsComeInOrderAndAtOneRevision) {
  constexpr uint32_t kSubmaps = 10'000;
  Submap submap;
  submap.id.session = SessionId("alice-1");
  submap.robot = RobotId("alice");
  submap.keyframes.resize(1);
  submap.points = {{1, 2, 3, 0, 0}, {-1, 0, 4, 0, 0}};
  for (submap.id.index = 0; submap.id.index < kSubmaps; ++submap.id.index) {
    ASSERT_TRUE(pipeline_.sessions().AddSubmap(submap).ok());
    pipeline_.placed[ToString(submap.id)] = Pose(Eigen::Vector3d(0.1, 0.2, 0.3));
  }
  pipeline_.info.revision = 7;
  const auto context = NewContext();
  auto reader = stubs_->map->ListSubmaps(context.get(), {});
  v1::ListSubmapsResponse response;
  uint32_t next = 0;
  int responses = 0;
  while (reader->Read(&response)) {
    pipeline_.info.revision = 8;  // The map goes on while it is read.
    EXPECT_EQ(response.revision(), 7);
    EXPECT_LT(response.ByteSizeLong(), kGrpcLimit / 2);
    for (const v1::Submap& listed : response.submaps()) EXPECT_EQ(listed.index(), next++);
    ++responses;
  }
  EXPECT_GRPC_OK(reader->Finish());
  EXPECT_EQ(next, kSubmaps);
  EXPECT_GT(responses, 1);
}

TEST_F(ListRpcTest, AMatchMayHaveMoreEdgesThanAResponseTakes) {
  constexpr uint32_t kEdges = 30'000;
  pipeline_.graph.revision = 5;
  pipeline_.graph.matches = {MatchOf("alice-1", "bob-1", kEdges), MatchOf("alice-1", "carol-1", 3)};
  pipeline_.graph.placements.resize(1);
  v1::GetMatchGraphRequest request;
  request.set_include_edges(true);
  std::vector<v1::GetMatchGraphResponse> responses;
  EXPECT_GRPC_OK(ReadAll(stubs_->map->GetMatchGraph(NewContext().get(), request), &responses));
  std::vector<std::vector<uint32_t>> edges;  // By match.
  int placements = 0;
  for (const v1::GetMatchGraphResponse& response : responses) {
    EXPECT_EQ(response.revision(), 5);
    EXPECT_LT(response.ByteSizeLong(), kGrpcLimit / 2);
    for (const v1::SubmapEdge& edge : response.more_edges()) {
      ASSERT_FALSE(edges.empty());
      edges.back().push_back(edge.submap_a());
    }
    for (const v1::Match& match : response.matches()) {
      std::vector<uint32_t>& begun = edges.emplace_back();
      for (const v1::SubmapEdge& edge : match.edges()) begun.push_back(edge.submap_a());
    }
    placements += response.placements_size();
  }
  ASSERT_EQ(edges.size(), 2u);
  ASSERT_EQ(edges[0].size(), kEdges);
  for (uint32_t k = 0; k < kEdges; ++k) EXPECT_EQ(edges[0][k], k);
  EXPECT_THAT(edges[1], testing::ElementsAre(0, 1, 2));
  EXPECT_EQ(placements, 1);
}

TEST_F(ListRpcTest, AnEmptyListStillNamesTheRevision) {
  pipeline_.info.revision = 6;
  std::vector<v1::ListSubmapsResponse> submaps;
  EXPECT_GRPC_OK(ReadAll(stubs_->map->ListSubmaps(NewContext().get(), {}), &submaps));
  ASSERT_EQ(submaps.size(), 1u);
  EXPECT_EQ(submaps[0].revision(), 6);
  std::vector<v1::ListAnchorsResponse> anchors;
  EXPECT_GRPC_OK(ReadAll(stubs_->map->ListAnchors(NewContext().get(), {}), &anchors));
  ASSERT_EQ(anchors.size(), 1u);
  EXPECT_EQ(anchors[0].revision(), 6);
}

TEST_F(ListRpcTest, ManyAnchorsComeInSeveralResponses) {
  constexpr uint32_t kAnchors = 3000;
  Anchor anchor;
  anchor.submap.session = SessionId("alice-1");
  anchor.note = std::string(1000, 'x');
  pipeline_.anchored = 1;
  for (; anchor.submap.index < kAnchors; ++anchor.submap.index) {
    ASSERT_TRUE(pipeline_.decisions().PutAnchor(anchor, {}).ok());
  }
  std::vector<v1::ListAnchorsResponse> responses;
  EXPECT_GRPC_OK(ReadAll(stubs_->map->ListAnchors(NewContext().get(), {}), &responses));
  EXPECT_GT(responses.size(), 2u);
  uint32_t next = 0;
  for (const v1::ListAnchorsResponse& response : responses) {
    EXPECT_LT(response.ByteSizeLong(), kGrpcLimit / 2);
    for (const v1::Anchor& listed : response.anchors()) EXPECT_EQ(listed.index(), next++);
  }
  EXPECT_EQ(next, kAnchors);
}

}  // namespace
}  // namespace isthmus::rpc
