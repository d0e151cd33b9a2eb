// The event log over a real socket: lists, watches, what a slow or a returning watcher is told.
#include <absl/strings/str_cat.h>

#include "tests/server/rpc/rpc_fixture.h"

namespace isthmus::rpc {
namespace {

using testing::ElementsAre;

Event MakeEvent(EventKind kind, const std::string& robot, const std::string& text = "it happened") {
  Event event;
  event.time_ns = 1000;
  event.kind = kind;
  event.robot = RobotId(robot);
  event.text = text;
  return event;
}

class EventRpcTest : public RpcTest {
 protected:
  using Reader = std::unique_ptr<grpc::ClientReader<v1::WatchEventsResponse>>;

  v1::ListEventsResponse List(const v1::ListEventsRequest& request = {}) {
    v1::ListEventsResponse list;
    EXPECT_GRPC_OK(Merged(stubs_->events->ListEvents(NewContext().get(), request), &list));
    return list;
  }
  Reader Watch(grpc::ClientContext* context, std::optional<uint64_t> after) {
    v1::WatchEventsRequest request;
    if (after) request.set_after(*after);
    return stubs_->events->WatchEvents(context, request);
  }
  // Reads until so many events came; returns their numbers.
  static std::vector<uint64_t> Read(const Reader& reader, size_t count) {
    std::vector<uint64_t> numbers;
    v1::WatchEventsResponse response;
    while (numbers.size() < count && reader->Read(&response)) {
      for (const v1::Event& event : response.events()) numbers.push_back(event.number());
    }
    return numbers;
  }
};

TEST_F(EventRpcTest, ListsWhatWasNoted) {
  Event event = MakeEvent(EventKind::kMatchDecided, "alice", "bad \xff byte");
  event.actor = {"chief", "ipv4:10.0.0.7:1", "deploy-12"};
  event.session = SessionId("alice-1");
  pipeline_.events().Note(event);
  const v1::ListEventsResponse list = List();
  ASSERT_EQ(list.events_size(), 1);
  const v1::Event& listed = list.events(0);
  EXPECT_EQ(listed.number(), 1u);
  EXPECT_EQ(listed.time_ns(), 1000);
  EXPECT_EQ(listed.kind(), v1::MATCH_DECIDED);
  EXPECT_EQ(listed.text(), "bad ? byte");
  EXPECT_EQ(listed.who(), "chief");
  EXPECT_EQ(listed.from(), "ipv4:10.0.0.7:1");
  EXPECT_EQ(listed.request_id(), "deploy-12");
  EXPECT_EQ(listed.robot(), "alice");
  EXPECT_EQ(listed.session(), "alice-1");
  EXPECT_EQ(list.newest(), 1u);
  EXPECT_EQ(list.up_to(), 1u);
  EXPECT_EQ(list.first_kept(), 1u);
}

TEST_F(EventRpcTest, KindsAndRobotsAreFiltered) {
  for (const char* robot : {"alice", "bob"}) {
    pipeline_.events().Note(MakeEvent(EventKind::kRobotLost, robot));
    pipeline_.events().Note(MakeEvent(EventKind::kRobotFound, robot));
  }
  v1::ListEventsRequest request;
  request.add_kinds(v1::ROBOT_FOUND);
  request.set_robot("bob");
  ASSERT_EQ(List(request).events_size(), 1);
  EXPECT_EQ(List(request).events(0).number(), 4u);
  request.add_kinds(static_cast<v1::EventKind>(999));
  v1::ListEventsResponse list;
  EXPECT_GRPC_ERROR(Merged(stubs_->events->ListEvents(NewContext().get(), request), &list),
                    INVALID_ARGUMENT, "999");
}

TEST_F(EventRpcTest, EveryKindHasAMessage) {
  for (const EventKind kind : AllEventKinds()) pipeline_.events().Note(MakeEvent(kind, ""));
  const v1::ListEventsResponse list = List();
  ASSERT_EQ(static_cast<size_t>(list.events_size()), AllEventKinds().size());
  for (int k = 0; k < list.events_size(); ++k) {
    EXPECT_EQ(v1::EventKind_Name(list.events(k).kind()),
              ToString(AllEventKinds()[static_cast<size_t>(k)]));
  }
}

TEST_F(EventRpcTest, AChangeNamesWhoAskedForIt) {
  const auto context = NewContext();
  context->AddMetadata("x-request-id", "deploy-12");
  v1::DecideLoopRequest request;
  request.set_decision(v1::DecideLoopRequest::REJECT);
  v1::DecideLoopResponse response;
  EXPECT_FALSE(stubs_->edits->DecideLoop(context.get(), request, &response).ok());
  ASSERT_EQ(pipeline_.actors.size(), 1u);
  EXPECT_EQ(pipeline_.actors[0].request_id, "deploy-12");
  EXPECT_EQ(pipeline_.actors[0].who, "");
  EXPECT_THAT(pipeline_.actors[0].from, testing::StartsWith("ipv4:127.0.0.1:"));
}

TEST_F(EventRpcTest, AWatchTellsWhatThereIsAndWhatComes) {
  pipeline_.events().Note(MakeEvent(EventKind::kRobotLost, "alice"));
  const auto context = NewContext();
  const Reader reader = Watch(context.get(), 0);
  EXPECT_THAT(Read(reader, 1), ElementsAre(1));
  pipeline_.events().Note(MakeEvent(EventKind::kRobotFound, "alice"));
  EXPECT_THAT(Read(reader, 1), ElementsAre(2));
  pipeline_.events().Note(MakeEvent(EventKind::kRobotLost, "alice"));
  pipeline_.events().Note(MakeEvent(EventKind::kRobotFound, "alice"));
  EXPECT_THAT(Read(reader, 2), ElementsAre(3, 4));
  context->TryCancel();
  EXPECT_EQ(reader->Finish().error_code(), grpc::StatusCode::CANCELLED);
}

TEST_F(EventRpcTest, AWatchWithoutANumberBeginsNow) {
  pipeline_.events().Note(MakeEvent(EventKind::kRobotLost, "alice"));
  const auto context = NewContext();
  const Reader reader = Watch(context.get(), std::nullopt);
  v1::WatchEventsResponse first;
  ASSERT_TRUE(reader->Read(&first));  // The first message says that it has begun.
  EXPECT_EQ(first.events_size(), 0);
  EXPECT_EQ(first.up_to(), 1u);
  pipeline_.events().Note(MakeEvent(EventKind::kRobotFound, "alice"));
  EXPECT_THAT(Read(reader, 1), ElementsAre(2));
  context->TryCancel();
}

// A thousand events of half a kilobyte do not fit into gRPC's buffers for a client that does not
// read.
TEST_F(EventRpcTest, ASlowReaderIsToldOfEachEventOnce) {
  constexpr size_t kEvents = 3000;
  const auto context = NewContext();
  const Reader reader = Watch(context.get(), 0);
  for (size_t k = 0; k < kEvents; ++k) {
    pipeline_.events().Note(MakeEvent(EventKind::kLoopClosed, "alice", std::string(500, 'x')));
  }
  const std::vector<uint64_t> numbers = Read(reader, kEvents);
  ASSERT_EQ(numbers.size(), kEvents);
  for (size_t k = 0; k < kEvents; ++k) ASSERT_EQ(numbers[k], k + 1);
  context->TryCancel();
}

TEST_F(EventRpcTest, WhoAsksFromBeforeWhatIsKeptIsToldWhereItStarts) {
  // By the store's own limit, in one go.
  pipeline_.NoteAll(
      std::vector<Event>(storage::kEventsKept + 5, MakeEvent(EventKind::kLoopClosed, "alice")));
  const auto context = NewContext();
  const Reader reader = Watch(context.get(), 2);
  v1::WatchEventsResponse response;
  ASSERT_TRUE(reader->Read(&response));
  EXPECT_EQ(response.after(), 2u);
  EXPECT_EQ(response.first_kept(), 6u);
  EXPECT_EQ(response.events(0).number(), 6u);
  context->TryCancel();
}

TEST_F(EventRpcTest, ANumberOfAnotherLogIsRefused) {
  const auto context = NewContext();
  const Reader reader = Watch(context.get(), 7);
  v1::WatchEventsResponse response;
  EXPECT_FALSE(reader->Read(&response));
  EXPECT_GRPC_ERROR(reader->Finish(), OUT_OF_RANGE, "begin at 0");
  v1::ListEventsRequest request;
  request.set_after(7);
  v1::ListEventsResponse list;
  EXPECT_GRPC_ERROR(Merged(stubs_->events->ListEvents(NewContext().get(), request), &list),
                    OUT_OF_RANGE, "begin at 0");
}

TEST_F(EventRpcTest, WatchesEndWithTheServer) {
  const auto context = NewContext();
  const Reader reader = Watch(context.get(), 0);
  v1::WatchEventsResponse response;
  ASSERT_TRUE(reader->Read(&response));
  server_->Shutdown(std::chrono::seconds(1));
  EXPECT_FALSE(reader->Read(&response));
  EXPECT_EQ(reader->Finish().error_code(), grpc::StatusCode::UNAVAILABLE);
}

}  // namespace
}  // namespace isthmus::rpc
