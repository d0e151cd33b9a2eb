// The client against a server that starts late, damages what it sends, or is not there.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <optional>

#include "api/convert/retry_after.h"
#include "client/library/client.h"
#include "client/library/stream/session_link.h"
#include "core/codec/payload_builder.h"
#include "core/io/file_io.h"
#include "tests/client/library/fake_server.h"

namespace isthmus::client {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

int FreePort() { return FakeServer().port(); }

std::string Scratch(const std::string& name) {
  const auto folder = std::filesystem::path(testing::TempDir()) / "isthmus_client_retry";
  std::filesystem::create_directories(folder);
  return folder / name;
}

std::unique_ptr<Client> ConnectTo(const FakeServer& server) {
  ClientOptions options;
  options.address = server.address();
  options.sleep = [](double) {};
  auto client = Client::Connect(options);
  EXPECT_TRUE(client.ok()) << client.status();
  return std::move(*client);
}

TEST(ClientRetry, WaitsForAServerThatStartsLate) {
  const int port = FreePort();
  std::optional<FakeServer> server;
  std::vector<double> waits;
  ClientOptions options;
  options.address = "127.0.0.1:" + std::to_string(port);
  options.backoff = {.first_delay_s = 1, .factor = 2, .max_delay_s = 60, .jitter = 0};
  options.sleep = [&](double seconds) {
    waits.push_back(seconds);
    if (waits.size() == 3) server.emplace(port);
  };
  const auto client = Client::Connect(options);
  ASSERT_TRUE(client.ok()) << client.status();
  EXPECT_THAT(waits, ElementsAre(1, 2, 4));
  EXPECT_EQ((*client)->GetMapInfo()->revision, 7);
}

// Waits are counted; goes from one address to the next without any.
ClientOptions OfServers(const std::string& addresses, std::atomic<int>* waits) {
  ClientOptions options;
  options.address = addresses;
  options.sleep = [waits](double seconds) { *waits += seconds > 0; };
  return options;
}

TEST(ClientRetry, FindsTheServerThatHasTheMap) {
  const std::string nobody = "127.0.0.1:" + std::to_string(FreePort());
  FakeServer server;
  std::atomic<int> waits = 0;
  // By its name, too.
  const std::string name = "localhost:" + std::to_string(server.port());
  const auto client = Client::Connect(OfServers(nobody + "," + name, &waits));
  ASSERT_TRUE(client.ok()) << client.status();
  EXPECT_EQ((*client)->GetMapInfo()->revision, 7);
  EXPECT_EQ(waits, 0);
}

TEST(ClientRetry, GoesOnToTheNextServerWhenOneIsGone) {
  std::atomic<int> waits = 0;
  auto first = std::make_unique<FakeServer>();
  FakeServer second;
  const auto client = Client::Connect(OfServers(first->address() + "," + second.address(), &waits));
  ASSERT_TRUE(client.ok()) << client.status();
  ASSERT_TRUE((*client)->CreateSession("alice", "vlp16").ok());
  EXPECT_EQ(first->sessions.creations, 1);
  EXPECT_EQ(second.sessions.creations, 0);
  const int port = first->port();
  first.reset();
  EXPECT_TRUE((*client)->CreateSession("alice", "vlp16").ok());
  EXPECT_EQ(second.sessions.creations, 1);
  // It stays there while that answers, and what must not be sent twice is sent once.
  first = std::make_unique<FakeServer>(port);
  second.edits.lose = 1;
  EXPECT_TRUE(absl::IsUnavailable((*client)->UndoRevision(3).status()));
  EXPECT_EQ(first->edits.undone + second.edits.undone, 1);
  EXPECT_EQ(waits, 0);
}

TEST(ClientRetry, WhereNoneHasTheMapItWaitsOnceForAll) {
  const std::string nobody = "127.0.0.1:" + std::to_string(FreePort());
  std::atomic<int> waits = 0;
  ClientOptions options = OfServers(nobody + "," + nobody, &waits);
  options.backoff.max_attempts = 4;
  const absl::Status status = Client::Connect(options).status();
  EXPECT_TRUE(absl::IsUnavailable(status));
  EXPECT_THAT(std::string(status.message()), HasSubstr("no server there has the map"));
  EXPECT_EQ(waits, 3);
  EXPECT_TRUE(absl::IsInvalidArgument(Client::Connect({.address = "a:1,b"}).status()));
}

// A link without a server.
class NoLink final : public SessionLink {
 public:
  using SessionLink::SessionLink;
  std::unique_ptr<SessionCall> NewCall(double) override { return nullptr; }
};

TEST(ClientRetry, WaitsAsLongAsAFullServerAsksFor) {
  std::vector<double> waits;
  ClientOptions options;
  options.backoff = {.first_delay_s = 1, .factor = 2, .max_delay_s = 60, .jitter = 0};
  options.sleep = [&](double seconds) { waits.push_back(seconds); };
  NoLink link(options);
  const absl::Status full = convert::WithRetryAfter(absl::ResourceExhaustedError("too many"),
                                                    std::chrono::milliseconds(2500));
  int attempts = 0;
  EXPECT_TRUE(link.Repeat(false, [&] { return ++attempts < 3 ? full : absl::OkStatus(); }).ok());
  EXPECT_THAT(waits, ElementsAre(3.5, 4.5));
  // One that does not say when is not asked again: more of the same would not help.
  attempts = 0;
  EXPECT_TRUE(absl::IsResourceExhausted(link.Repeat(false, [&] {
    ++attempts;
    return absl::ResourceExhaustedError("a scan too large");
  })));
  EXPECT_EQ(attempts, 1);
}

TEST(ClientRetry, SaysWhereItSoughtTheServerAndWhatToDo) {
  ClientOptions options;
  options.address = "127.0.0.1:" + std::to_string(FreePort());
  options.backoff.max_attempts = 2;
  options.sleep = [](double) {};
  const absl::Status status = Client::Connect(options).status();
  EXPECT_TRUE(absl::IsUnavailable(status));
  EXPECT_THAT(std::string(status.message()),
              HasSubstr("cannot reach isthmus-server at " + options.address +
                        ": is it running? Start it with `isthmus-server"));
}

TEST(ClientRetry, FindsTheServerAgainAfterARestart) {
  auto server = std::make_unique<FakeServer>();
  const int port = server->port();
  const auto client = ConnectTo(*server);
  server.reset();
  server = std::make_unique<FakeServer>(port);
  EXPECT_TRUE(client->CreateSession("alice", "vlp16").ok());
  EXPECT_EQ(server->sessions.creations, 1);
}

TEST(ClientRetry, OtherErrorsAreNotTriedAgain) {
  FakeServer server;
  const auto client = ConnectTo(server);
  EXPECT_TRUE(absl::IsNotFound(client->GetSession(SessionId("bob-1")).status()));
  EXPECT_TRUE(absl::IsUnimplemented(client->GetMatchGraph().status()));
}

TEST(ClientRetry, AListThatWasCutOffIsReadFromItsBeginning) {
  FakeServer server;
  server.map.break_lists = 2;
  const auto submaps = ConnectTo(server)->ListSubmaps();
  ASSERT_TRUE(submaps.ok()) << submaps.status();
  ASSERT_EQ(submaps->size(), 2u);
  EXPECT_EQ(submaps->at(0).info.id.index, 0u);
  EXPECT_EQ(submaps->at(1).info.id.index, 1u);
  EXPECT_EQ(submaps->revision, 3);
}

TEST(ClientRetry, ChangesThatAreNotTheSameTwiceAreSentOnce) {
  FakeServer server;
  const auto client = ConnectTo(server);
  Anchor anchor;
  anchor.sigma_xy_m = 1;
  server.edits.lose = 3;
  EXPECT_TRUE(absl::IsUnavailable(client->UndoRevision(3).status()));
  EXPECT_TRUE(absl::IsUnavailable(client->RemoveAnchor({SessionId("alice-1"), 0}).status()));
  EXPECT_TRUE(absl::IsUnavailable(client->PutAnchor(anchor, RobotId("alice")).status()));
  EXPECT_EQ(server.edits.undone, 1);
  EXPECT_EQ(server.edits.removed, 1);
  EXPECT_EQ(server.edits.put, 1) << "another submap may be the newest by now";
  server.edits.lose = 2;
  anchor.submap.session = SessionId("alice-1");
  EXPECT_TRUE(client->PutAnchor(anchor).ok());
  EXPECT_EQ(server.edits.put, 4) << "the same anchor twice is one";
}

TEST(ClientRetry, ASubmapDamagedOnItsWayIsSentAgain) {
  FakeServer server;
  server.sessions.spoil_uploads = 2;
  const auto client = ConnectTo(server);
  SubmapUpload submap;
  submap.id = {SessionId("alice-1"), 0};
  submap.cloud = codec::MakePayload(Cloud(200'000, {1, 2, 3, 4}));  // 3.2 MB: several chunks.
  EXPECT_TRUE(client->UploadSubmap(submap).ok());
  EXPECT_EQ(server.sessions.uploads, 3);
}

TEST(ClientExport, AFileAppearsWholeAndVerified) {
  FakeServer server;
  const std::string path = Scratch("whole.pcd");
  const auto summary = ConnectTo(server)->ExportToFile({}, path);
  ASSERT_TRUE(summary.ok()) << summary.status();
  EXPECT_EQ(summary->size, server.map.file.size());
  EXPECT_EQ(*io::ReadFile(path), server.map.file);
  EXPECT_FALSE(std::filesystem::exists(path + ".part"));
}

TEST(ClientExport, DamagedAndTruncatedExportsAreFetchedAgain) {
  FakeServer server;
  server.map.damaged = 1;
  server.map.truncated = 1;
  const std::string path = Scratch("again.pcd");
  ASSERT_TRUE(ConnectTo(server)->ExportToFile({}, path).ok());
  EXPECT_EQ(*io::ReadFile(path), server.map.file);
  EXPECT_EQ(server.map.exports, 3);
}

TEST(ClientExport, ADamagedExportNeverReplacesAFile) {
  FakeServer server;
  server.map.damaged = 1000;
  const std::string path = Scratch("kept.pcd");
  std::ofstream(path) << "older map";
  const absl::Status status = ConnectTo(server)->ExportToFile({}, path).status();
  EXPECT_TRUE(absl::IsDataLoss(status)) << status;
  EXPECT_EQ(*io::ReadFile(path), "older map");
  EXPECT_FALSE(std::filesystem::exists(path + ".part"));
}

TEST(ClientExport, AnExtensionOfAnotherFormatIsRefusedBeforeAnythingIsFetched) {
  FakeServer server;
  const auto client = ConnectTo(server);
  for (const char* name : {"map.las", "map.ply", "map.bt"}) {
    EXPECT_TRUE(absl::IsInvalidArgument(client->ExportToFile({}, Scratch(name)).status())) << name;
  }
  const std::string graph = Scratch("graph.json");
  EXPECT_TRUE(absl::IsInvalidArgument(client->ExportPoseGraphToFile(0, graph).status()));
  EXPECT_EQ(server.map.exports, 0);
  EXPECT_TRUE(client->ExportToFile({.format = ExportFormat::kPly}, Scratch("map.PLY")).ok());
}

TEST(ClientExport, AFolderThatDoesNotExistIsToldBeforeAnythingIsFetched) {
  FakeServer server;
  const absl::Status status =
      ConnectTo(server)->ExportToFile({}, "/nowhere/at/all/map.pcd").status();
  EXPECT_TRUE(absl::IsNotFound(status)) << status;
  EXPECT_THAT(std::string(status.message()), HasSubstr("/nowhere/at/all/map.pcd"));
  EXPECT_EQ(server.map.exports, 0);
}

TEST(ClientExport, WhatWasHandedOnIsNotFetchedAgain) {
  FakeServer server;
  server.map.truncated = 1;
  uint64_t received = 0;
  const auto summary = ConnectTo(server)->Export({}, [&](const std::string& bytes) {
    received += bytes.size();
    return true;
  });
  EXPECT_TRUE(absl::IsAborted(summary.status())) << summary.status();
  EXPECT_EQ(received, server.map.file.size() / 2);
  EXPECT_EQ(server.map.exports, 1);
}

TEST(ClientExport, TheReaderMayStop) {
  FakeServer server;
  const auto summary = ConnectTo(server)->Export({}, [](const std::string&) { return false; });
  EXPECT_TRUE(absl::IsCancelled(summary.status())) << summary.status();
}

}  // namespace
}  // namespace isthmus::client
