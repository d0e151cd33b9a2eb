// Records to messages and back: nothing is lost, and what a newer server says is no harm.
#include <gtest/gtest.h>

#include "api/convert/geometry.h"
#include "api/convert/graph.h"
#include "api/convert/map.h"
#include "api/convert/session.h"

namespace isthmus::convert {
namespace {

// Every value of an enumeration of the API, there and back: none is missing in the tables.
template <typename Message, typename Set, typename Get>
void ExpectAllKept(const google::protobuf::EnumDescriptor* values, const Set& set, const Get& get) {
  for (int i = 0; i < values->value_count(); ++i) {
    const int number = values->value(i)->number();
    Message message;
    set(message, number);
    EXPECT_EQ(get(ToMessage(FromMessage(message))), number) << values->value(i)->full_name();
  }
}

TEST(Convert, EveryValueOfAnEnumerationIsKept) {
  ExpectAllKept<v1::Match>(
      v1::Match::Reason_descriptor(),
      [](v1::Match& m, int number) { m.set_reason(static_cast<v1::Match::Reason>(number)); },
      [](const v1::Match& m) { return m.reason(); });
  ExpectAllKept<v1::Match>(
      v1::GuessSource_descriptor(),
      [](v1::Match& m, int number) { m.set_matcher(static_cast<v1::GuessSource>(number)); },
      [](const v1::Match& m) { return m.matcher(); });
  ExpectAllKept<v1::Session>(
      v1::Tracking_descriptor(),
      [](v1::Session& s, int number) { s.set_tracking(static_cast<v1::Tracking>(number)); },
      [](const v1::Session& s) { return s.tracking(); });
  ExpectAllKept<v1::Session>(
      v1::Odometry_descriptor(),
      [](v1::Session& s, int number) { s.set_odometry(static_cast<v1::Odometry>(number)); },
      [](const v1::Session& s) { return s.odometry(); });
}

// The other way round: clients are told each value that the server has.
TEST(Convert, EveryValueOfARecordIsTold) {
  MatchEdge edge;
  for (int i = 0; i <= static_cast<int>(GuessSource::kByHand); ++i) {
    edge.match.matcher = static_cast<GuessSource>(i);
    EXPECT_EQ(FromMessage(ToMessage(edge)).match.matcher, edge.match.matcher)
        << ToString(edge.match.matcher);
  }
  for (int i = 0; i <= static_cast<int>(MatchReason::kUnverified); ++i) {
    edge.match.reason = static_cast<MatchReason>(i);
    EXPECT_EQ(FromMessage(ToMessage(edge)).match.reason, edge.match.reason)
        << ToString(edge.match.reason);
  }
}

TEST(Convert, AnAskedDriveLosesNothing) {
  MatchEdge edge;
  edge.asked_drives = {{RobotId("bob"),
                        SessionId("bob-1"),
                        Pose(Eigen::Vector3d(7, 0, 0)),
                        {{1, 2, 3}, {4, 5, 6}},
                        1,
                        12,
                        0.97}};
  const std::vector<RobotDrive> drives = FromMessage(ToMessage(edge)).asked_drives;
  ASSERT_EQ(drives.size(), 1u);
  EXPECT_EQ(drives[0].robot, RobotId("bob"));
  EXPECT_EQ(drives[0].session, SessionId("bob-1"));
  EXPECT_EQ(drives[0].T_a_b.translation().x(), 7);
  ASSERT_EQ(drives[0].way.size(), 2u);
  EXPECT_EQ(drives[0].way[1], Eigen::Vector3d(4, 5, 6));
  EXPECT_EQ(drives[0].leaves_own, 1u);
  EXPECT_EQ(drives[0].length_m, 12);
  EXPECT_EQ(drives[0].confidence, 0.97);
}

TEST(Convert, NumbersOfANewerServerAreTakenForUnspecified) {
  v1::Match match;
  match.set_state(static_cast<v1::Match::State>(77));
  match.set_reason(static_cast<v1::Match::Reason>(77));
  match.set_matcher(static_cast<v1::GuessSource>(77));
  match.mutable_manual_decision()->set_kind(static_cast<v1::ManualDecision::Kind>(77));
  const MatchEdge edge = FromMessage(match);
  EXPECT_EQ(edge.match.state, MatchState::kNotYet);
  EXPECT_EQ(edge.match.reason, MatchReason::kNone);
  EXPECT_EQ(edge.match.matcher, GuessSource::kNone);
  v1::Session session;
  session.set_tracking(static_cast<v1::Tracking>(77));
  session.set_odometry(static_cast<v1::Odometry>(77));
  session.set_state(static_cast<v1::Session::State>(77));
  EXPECT_EQ(FromMessage(session).tracking, Tracking::kUnknown);
  EXPECT_FALSE(FromMessage(session).record.odometry.has_value());
  v1::StreamScansResponse ack;
  ack.set_outcome(static_cast<v1::StreamScansResponse::Outcome>(77));
  ack.set_tracking(static_cast<v1::Tracking>(77));
  EXPECT_EQ(FromMessage(ack).tracking, Tracking::kUnknown);
}

TEST(Convert, RequestsThatNameNoValueAreRefused) {
  v1::ExportMapRequest request;
  request.set_format(static_cast<v1::ExportMapRequest::Format>(77));
  EXPECT_TRUE(absl::IsInvalidArgument(FromMessage(request).status()));
  v1::DecideMatchRequest decision;
  decision.set_decision(static_cast<v1::DecideMatchRequest::Decision>(77));
  EXPECT_TRUE(absl::IsInvalidArgument(FromMessage(decision).status()));
}

TEST(Convert, AMatrixKeepsItsPlaces) {
  Matrix6d matrix;
  for (int i = 0; i < 6; ++i) {
    for (int k = 0; k < 6; ++k) matrix(i, k) = 10 * std::min(i, k) + std::max(i, k);
  }
  google::protobuf::RepeatedField<double> numbers;
  AddUpperTriangle(matrix, &numbers);
  EXPECT_EQ(FromUpperTriangle(numbers), matrix);
  numbers.RemoveLast();
  EXPECT_FALSE(FromUpperTriangle(numbers).has_value());
}

}  // namespace
}  // namespace isthmus::convert
