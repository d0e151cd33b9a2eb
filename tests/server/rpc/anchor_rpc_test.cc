// Anchors over a socket: requests arrive, answers come back.
#include <limits>

#include "tests/server/rpc/rpc_fixture.h"

namespace isthmus::rpc {
namespace {

class AnchorRpcTest : public RpcTest {
 protected:
  // Adds the next submap of a session.
  void AddSubmap(const std::string& session, const std::string& robot, uint32_t index) {
    Submap submap;
    submap.id = {SessionId(session), index};
    submap.robot = RobotId(robot);
    submap.keyframes.resize(1);
    submap.points = {{1, 2, 3, 0, 0}};
    ASSERT_TRUE(pipeline_.sessions().AddSubmap(submap).ok());
  }

  grpc::Status Put(const v1::PutAnchorRequest& request) {
    put_.Clear();
    return stubs_->edits->PutAnchor(NewContext().get(), request, &put_);
  }

  v1::PutAnchorResponse put_;
};

v1::PutAnchorRequest AnchorAt(double x) {
  v1::PutAnchorRequest request;
  v1::Anchor& anchor = *request.mutable_anchor();
  anchor.set_session("alice-1");
  anchor.set_index(7);
  anchor.mutable_t_map_submap()->mutable_translation()->set_x(x);
  anchor.set_sigma_xy_m(0.1);
  anchor.set_sigma_z_m(0.2);
  anchor.set_sigma_deg(3);
  anchor.set_note("total station");
  return request;
}

TEST_F(AnchorRpcTest, AnAnchorArrivesAndIsListed) {
  const std::string session = stubs_->NewSession("alice");
  pipeline_.anchored = 5;
  pipeline_.info.revision = 5;
  v1::PutAnchorRequest request = AnchorAt(12);
  request.mutable_anchor()->set_session(session);
  EXPECT_GRPC_OK(Put(request));
  EXPECT_EQ(put_.revision(), 5);
  EXPECT_EQ(put_.session(), session);
  EXPECT_EQ(put_.index(), 7u);
  v1::ListAnchorsResponse response;
  EXPECT_GRPC_OK(Merged(stubs_->map->ListAnchors(NewContext().get(), {}), &response));
  EXPECT_EQ(response.revision(), 5);
  ASSERT_EQ(response.anchors_size(), 1);
  const v1::Anchor& anchor = response.anchors(0);
  EXPECT_EQ(anchor.session(), session);
  EXPECT_EQ(anchor.index(), 7u);
  EXPECT_EQ(anchor.robot(), "alice");
  EXPECT_EQ(anchor.t_map_submap().translation().x(), 12);
  EXPECT_EQ(anchor.t_map_submap().rotation().w(), 1) << "absent means identity";
  EXPECT_EQ(anchor.sigma_xy_m(), 0.1);
  EXPECT_EQ(anchor.sigma_z_m(), 0.2);
  EXPECT_EQ(anchor.sigma_deg(), 3);
  EXPECT_EQ(anchor.note(), "total station");
}

TEST_F(AnchorRpcTest, ARobotMeansTheNewestSubmapOfItsNewestSession) {
  const std::string old_session = stubs_->NewSession("alice");
  const std::string other = stubs_->NewSession("bob");
  const std::string session = stubs_->NewSession("alice");
  pipeline_.anchored = 5;
  v1::PutAnchorRequest request = AnchorAt(1);
  request.mutable_anchor()->clear_session();
  request.set_robot("alice");
  EXPECT_GRPC_ERROR(Put(request), NOT_FOUND, "robot");
  AddSubmap(old_session, "alice", 30);
  EXPECT_GRPC_ERROR(Put(request), FAILED_PRECONDITION, "no submap yet");
  AddSubmap(session, "alice", 0);
  AddSubmap(session, "alice", 9);
  AddSubmap(other, "bob", 40);
  EXPECT_GRPC_OK(Put(request));
  EXPECT_EQ(put_.session(), session);
  EXPECT_EQ(put_.index(), 9u);
  ASSERT_EQ(pipeline_.anchors.size(), 1u);
  EXPECT_EQ(pipeline_.anchors[0].submap, (SubmapId{SessionId(session), 9}));
}

TEST_F(AnchorRpcTest, AnchorsThatCannotBeMeantAreRefused) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  pipeline_.anchored = 5;
  v1::PutAnchorRequest request;
  EXPECT_GRPC_ERROR(Put(request), INVALID_ARGUMENT, "t_map_submap");
  request = AnchorAt(kNan);
  EXPECT_GRPC_ERROR(Put(request), INVALID_ARGUMENT, "not finite");
  request = AnchorAt(0);
  request.mutable_anchor()->clear_session();
  EXPECT_GRPC_ERROR(Put(request), INVALID_ARGUMENT, "session and index, or a robot");
  request = AnchorAt(0);
  request.mutable_anchor()->set_sigma_xy_m(-1);
  EXPECT_GRPC_ERROR(Put(request), INVALID_ARGUMENT, "sigma_xy_m is -1");
  request = AnchorAt(0);
  request.mutable_anchor()->set_sigma_z_m(kNan);
  EXPECT_GRPC_ERROR(Put(request), INVALID_ARGUMENT, "sigma_z_m");
  request = AnchorAt(0);
  request.mutable_anchor()->set_sigma_deg(-0.5);
  EXPECT_GRPC_ERROR(Put(request), INVALID_ARGUMENT, "sigma_deg");
  request = AnchorAt(0);
  request.mutable_anchor()->set_note(std::string(1001, 'x'));
  EXPECT_GRPC_ERROR(Put(request), INVALID_ARGUMENT, "1001 characters");
  EXPECT_TRUE(pipeline_.anchors.empty());
  pipeline_.anchored = absl::NotFoundError("alice-1/7 is not in the map");
  EXPECT_GRPC_ERROR(Put(AnchorAt(0)), NOT_FOUND, "alice-1/7");
}

TEST_F(AnchorRpcTest, AnAnchorIsTakenAway) {
  v1::DeleteAnchorRequest request;
  request.set_session("alice-1");
  request.set_index(7);
  v1::DeleteAnchorResponse response;
  EXPECT_GRPC_ERROR(stubs_->edits->DeleteAnchor(NewContext().get(), request, &response), NOT_FOUND,
                    "submap");
  pipeline_.anchored = 8;
  EXPECT_GRPC_OK(stubs_->edits->DeleteAnchor(NewContext().get(), request, &response));
  EXPECT_EQ(response.revision(), 8);
  EXPECT_EQ(pipeline_.unanchored.back(), (SubmapId{SessionId("alice-1"), 7}));
}

TEST_F(AnchorRpcTest, ADatumIsSetToldAndTakenBack) {
  v1::SetDatumRequest request;
  request.mutable_datum()->set_latitude_deg(48.1);
  request.mutable_datum()->set_longitude_deg(11.6);
  request.mutable_datum()->set_altitude_m(520);
  request.mutable_datum()->set_heading_deg(-30);
  v1::SetDatumResponse response;
  EXPECT_GRPC_OK(stubs_->edits->SetDatum(NewContext().get(), request, &response));
  v1::MapInfo info;
  EXPECT_GRPC_OK(stubs_->map->GetMapInfo(NewContext().get(), {}, &info));
  ASSERT_TRUE(info.has_datum());
  EXPECT_EQ(info.datum().latitude_deg(), 48.1);
  EXPECT_EQ(info.datum().longitude_deg(), 11.6);
  EXPECT_EQ(info.datum().altitude_m(), 520);
  EXPECT_EQ(info.datum().heading_deg(), -30);
  request.mutable_datum()->set_latitude_deg(91);
  EXPECT_GRPC_ERROR(stubs_->edits->SetDatum(NewContext().get(), request, &response),
                    INVALID_ARGUMENT, "latitude of -90 to 90");
  EXPECT_GRPC_OK(stubs_->edits->SetDatum(NewContext().get(), {}, &response));
  EXPECT_GRPC_OK(stubs_->map->GetMapInfo(NewContext().get(), {}, &info));
  EXPECT_FALSE(info.has_datum());
}

}  // namespace
}  // namespace isthmus::rpc
