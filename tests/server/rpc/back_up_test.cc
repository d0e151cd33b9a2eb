// A backup over a socket: its first and its last message, and the calls that have to wait.
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "core/io/crc32c.h"
#include "server/access/token_text.h"
#include "server/access/tokens.h"
#include "tests/server/rpc/rpc_fixture.h"

namespace isthmus::rpc {
namespace {

absl::StatusOr<BackupContents> TwoPieces(const BackupSink& sink) {
  if (!sink.progress(0.5) || !sink.progress(1)) return absl::CancelledError("given up");
  sink.begin(5);
  if (!sink.piece("abc") || !sink.piece("de")) return absl::CancelledError("given up");
  return BackupContents{2, 3, 40, 500, 1, "submap alice-1/3: damaged\n"};
}

class BackUpTest : public RpcTest {
 protected:
  explicit BackUpTest(std::chrono::milliseconds progress = kProgress)
      : RpcTest(Options(this, progress)) {}

  static ServerOptions Options(BackUpTest* test, std::chrono::milliseconds progress) {
    ServerOptions options;
    options.streams.progress = progress;
    options.backup = [test](const BackupSink& sink) { return test->source_(sink); };
    return options;
  }

  grpc::Status Run() { return ReadAll(stubs_->admin->BackUp(NewContext().get(), {}), &responses_); }

  BackupSource source_ = TwoPieces;
  std::vector<v1::BackUpResponse> responses_;
};

TEST_F(BackUpTest, ProgressThenDataThenWhatIsInIt) {
  pipeline_.info.revision = 6;
  EXPECT_GRPC_OK(Run());
  std::string bytes;
  for (const v1::BackUpResponse& response : responses_) {
    bytes += response.data();
    EXPECT_EQ(response.revision(), 6);
  }
  EXPECT_EQ(bytes, "abcde");
  EXPECT_EQ(responses_.front().copied(), 0.5);
  EXPECT_FALSE(responses_.front().last());
  const v1::BackUpResponse& last = responses_.back();
  EXPECT_TRUE(last.last());
  EXPECT_EQ(last.size(), 5u);
  EXPECT_EQ(last.crc32c(), io::Crc32c("abcde", 5, 0));
  EXPECT_EQ(last.contents().sessions(), 2);
  EXPECT_EQ(last.contents().submaps(), 3);
  EXPECT_EQ(last.contents().scans(), 40);
  EXPECT_EQ(last.contents().points(), 500);
  EXPECT_EQ(last.contents().damaged(), 1);
  EXPECT_EQ(last.contents().report(), "submap alice-1/3: damaged\n");
}

// The tokens for the site go along if they are asked for.
TEST(BackUpOfTokens, GoAlongIfTheyAreAskedFor) {
  std::string folder = testing::TempDir() + "isthmus-backup-XXXXXX";
  ASSERT_NE(mkdtemp(folder.data()), nullptr);
  const auto tokens = *access::Tokens::Open(folder);
  const std::string secret = tokens->Create({"chief", AccessRole::kAdmin, {}, {"*"}})->secret;
  ASSERT_TRUE(tokens->Create({"other", AccessRole::kReader, {}, {"yard"}}).ok());
  FakePipeline pipeline;
  ServerOptions options;
  options.listen = "127.0.0.1:0";
  options.tokens = tokens.get();
  options.backup = TwoPieces;
  const auto server = *RpcServer::Start(&pipeline, options);
  const Stubs stubs(grpc::CreateChannel(server->address(), grpc::InsecureChannelCredentials()));
  const auto back_up = [&](bool with_tokens) {
    const auto context = NewContext();
    context->AddMetadata("authorization", "Bearer " + secret);
    v1::BackUpRequest request;
    request.set_tokens(with_tokens);
    std::vector<v1::BackUpResponse> responses;
    EXPECT_GRPC_OK(ReadAll(stubs.admin->BackUp(context.get(), request), &responses));
    return responses.back().tokens();
  };
  EXPECT_EQ(back_up(false), "");
  const auto kept = access::ParseTokens(back_up(true));
  ASSERT_TRUE(kept.ok()) << kept.status();
  ASSERT_EQ(kept->size(), 1u);
  EXPECT_EQ(kept->front().token.name, "chief");
  std::filesystem::remove_all(folder);
}

TEST_F(BackUpTest, AReaderThatIsGoneEndsIt) {
  std::atomic<bool> endless = true;
  source_ = [&endless](const BackupSink& sink) -> absl::StatusOr<BackupContents> {
    if (!endless) return TwoPieces(sink);
    sink.begin(1);
    while (sink.piece(std::string(100'000, 'x'))) {
    }
    return absl::CancelledError("given up");
  };
  const auto context = NewContext();
  auto reader = stubs_->admin->BackUp(context.get(), {});
  v1::BackUpResponse response;
  EXPECT_TRUE(reader->Read(&response));
  context->TryCancel();
  while (reader->Read(&response)) {
  }
  EXPECT_EQ(reader->Finish().error_code(), grpc::StatusCode::CANCELLED);
  endless = false;
  grpc::Status next = Run();
  while (next.error_code() == grpc::StatusCode::RESOURCE_EXHAUSTED) next = Run();
  EXPECT_GRPC_OK(next);
}

class ImpatientBackUpTest : public BackUpTest {
 protected:
  ImpatientBackUpTest() : BackUpTest(std::chrono::milliseconds(200)) {}
};

TEST_F(ImpatientBackUpTest, AReaderThatStopsGivesUpTheOnePlace) {
  std::atomic<bool> endless = true;
  source_ = [&endless](const BackupSink& sink) -> absl::StatusOr<BackupContents> {
    if (!endless) return TwoPieces(sink);
    sink.begin(1);
    while (sink.piece(std::string(100'000, 'x'))) {
    }
    endless = false;
    return absl::CancelledError("given up");
  };
  const auto context = NewContext();
  const auto reader = stubs_->admin->BackUp(context.get(), {});
  v1::BackUpResponse response;
  ASSERT_TRUE(reader->Read(&response));
  // It reads no more, and holds the place until it is ended for that.
  grpc::Status next;
  do {
    next = Run();
  } while (next.error_code() == grpc::StatusCode::RESOURCE_EXHAUSTED &&
           std::chrono::system_clock::now() < context->deadline());
  EXPECT_GRPC_OK(next);
  while (reader->Read(&response)) {
  }
  EXPECT_EQ(reader->Finish().error_code(), grpc::StatusCode::CANCELLED);
}

TEST_F(BackUpTest, FailuresOfTheSourceReachTheReader) {
  source_ = [](const BackupSink&) -> absl::StatusOr<BackupContents> {
    return absl::ResourceExhaustedError("disk full");
  };
  EXPECT_GRPC_ERROR(Run(), RESOURCE_EXHAUSTED, "disk full");
}

TEST_F(BackUpTest, OneAtATime) {
  grpc::Status second;
  source_ = [&](const BackupSink& sink) {
    std::vector<v1::BackUpResponse> responses;
    second = ReadAll(stubs_->admin->BackUp(NewContext().get(), {}), &responses);
    return TwoPieces(sink);
  };
  EXPECT_GRPC_OK(Run());
  EXPECT_GRPC_ERROR(second, RESOURCE_EXHAUSTED, "another backup");
}

class NoBackupsTest : public RpcTest {};

TEST_F(NoBackupsTest, AServerThatStoresNothingSaysSo) {
  std::vector<v1::BackUpResponse> responses;
  EXPECT_GRPC_ERROR(ReadAll(stubs_->admin->BackUp(NewContext().get(), {}), &responses),
                    UNIMPLEMENTED, "stores nothing");
}

}  // namespace
}  // namespace isthmus::rpc
