// Limits of what one client holds, and for how long: streams without threads, limits that say when
// to come again, clients that say nothing, do not read, or send what is damaged.
#include <grpcpp/generic/generic_stub.h>

#include <chrono>
#include <string>
#include <thread>
#include <vector>

#include "api/convert/retry_after.h"
#include "isthmus/v1/localisation_service.grpc.pb.h"
#include "tests/server/rpc/rpc_fixture.h"

namespace isthmus::rpc {
namespace {

using ScanWire = grpc::ClientReaderWriter<v1::StreamScansRequest, v1::StreamScansResponse>;

v1::StreamScansRequest Naming(const std::string& session) {
  v1::StreamScansRequest request;
  request.set_session(session);
  return request;
}

v1::StreamScansRequest ScanOf(uint64_t sequence, size_t bytes = 12) {
  v1::StreamScansRequest request;
  request.mutable_scan()->set_sequence(sequence);
  v1::PointCloud& cloud = *request.mutable_scan()->mutable_cloud();
  cloud.set_encoding(v1::PointCloud::RAW);
  cloud.set_width(static_cast<uint32_t>(bytes / 12));
  cloud.set_stride(12);
  cloud.set_data(std::string(bytes, '\0'));
  return request;
}

// A stream with the context that it needs.
struct OpenStream {
  explicit OpenStream(const Stubs& stubs)
      : context(NewContext()), wire(stubs.sessions->StreamScans(context.get())) {}
  ~OpenStream() {
    context->TryCancel();
    if (!finished) wire->Finish();
  }
  grpc::Status Finish() {
    finished = true;
    return wire->Finish();
  }
  std::unique_ptr<grpc::ClientContext> context;
  std::unique_ptr<ScanWire> wire;
  bool finished = false;
};

class LimitsTest : public RpcTest {
 protected:
  explicit LimitsTest(const ServerOptions& options) : RpcTest(options) {}
  LimitsTest() : LimitsTest(Small()) {}

  static ServerOptions Small() {
    ServerOptions options;
    options.max_threads = 8;
    options.calls.streams = 101;
    options.calls.streams_per_caller = 100;
    options.calls.queries = 8;
    return options;
  }
};

TEST_F(LimitsTest, AHundredIdleStreamsHoldNoThread) {
  std::vector<std::unique_ptr<OpenStream>> streams;
  for (int i = 0; i < 100; ++i) {
    streams.push_back(std::make_unique<OpenStream>(*stubs_));
    const std::string session = stubs_->NewSession("alice");
    ASSERT_TRUE(streams.back()->wire->Write(Naming(session)));
    ASSERT_TRUE(streams.back()->wire->Write(ScanOf(1)));
    v1::StreamScansResponse ack;
    ASSERT_TRUE(streams.back()->wire->Read(&ack)) << i;
  }
  // Eight threads are there for all.
  v1::MapInfo info;
  EXPECT_GRPC_OK(stubs_->map->GetMapInfo(NewContext().get(), {}, &info));

  // One more is one too many of this caller, until one of them ends.
  OpenStream refused(*stubs_);
  v1::StreamScansResponse ack;
  EXPECT_FALSE(refused.wire->Read(&ack));
  const grpc::Status status = refused.Finish();
  EXPECT_GRPC_ERROR(status, RESOURCE_EXHAUSTED, "network.max_streams_per_caller");
  const auto& trailers = refused.context->GetServerTrailingMetadata();
  const auto after = trailers.find("retry-after-ms");
  ASSERT_NE(after, trailers.end());
  EXPECT_EQ(std::string(after->second.data(), after->second.size()), "1000");
  EXPECT_EQ(convert::RetryAfter(
                convert::WithDetails(absl::ResourceExhaustedError(""), status.error_details())),
            std::chrono::milliseconds(1000));
  streams[7]->wire->WritesDone();
  while (streams[7]->wire->Read(&ack)) {
  }
  EXPECT_GRPC_OK(streams[7]->Finish());
  streams.clear();
  OpenStream again(*stubs_);
  const std::string session = stubs_->NewSession("alice");
  ASSERT_TRUE(again.wire->Write(Naming(session)));
  ASSERT_TRUE(again.wire->Write(ScanOf(1)));
  EXPECT_TRUE(again.wire->Read(&ack));
}

TEST_F(LimitsTest, ADamagedMessageIsNotTheEndOfTheStream) {
  grpc::GenericStub stub(channel_);
  const auto context = NewContext();
  grpc::CompletionQueue queue;
  const auto wait = [&queue] {
    void* tag = nullptr;
    bool ok = false;
    EXPECT_TRUE(queue.Next(&tag, &ok));
    return ok;
  };
  const auto write = [&](auto& call, const std::string& bytes) {
    const grpc::Slice slice(bytes);
    call.Write(grpc::ByteBuffer(&slice, 1), nullptr);
    EXPECT_TRUE(wait());
  };
  auto call = stub.PrepareCall(context.get(), "/isthmus.v1.SessionService/StreamScans", &queue);
  call->StartCall(nullptr);
  wait();
  v1::StreamScansRequest first = ScanOf(1);
  first.set_session(stubs_->NewSession("alice"));
  write(*call, first.SerializeAsString());
  grpc::ByteBuffer ack;
  call->Read(&ack, nullptr);
  EXPECT_TRUE(wait()) << "what came before is acknowledged";
  write(*call, "\x12\xff\xff\xff");
  call->Read(&ack, nullptr);
  EXPECT_FALSE(wait());
  grpc::Status status;
  call->Finish(&status, nullptr);
  wait();
  EXPECT_GRPC_ERROR(status, INVALID_ARGUMENT, "StreamScansRequest");
}

TEST_F(LimitsTest, NamesOfFieldsAndReasonsAreShort) {
  OpenStream stream(*stubs_);
  v1::StreamScansRequest named = ScanOf(1);
  named.set_session(stubs_->NewSession("alice"));
  named.mutable_scan()->mutable_cloud()->add_fields()->set_name(std::string(65, 'x'));
  ASSERT_TRUE(stream.wire->Write(named));
  v1::StreamScansRequest long_name = ScanOf(2);
  long_name.mutable_scan()->mutable_cloud()->add_fields()->set_name(std::string(1 << 20, 'x'));
  ASSERT_TRUE(stream.wire->Write(long_name));
  for (int i = 0; i < 2; ++i) {
    v1::StreamScansResponse ack;
    ASSERT_TRUE(stream.wire->Read(&ack));
    EXPECT_EQ(ack.outcome(), v1::StreamScansResponse::REJECTED);
    EXPECT_THAT(ack.reason(), testing::HasSubstr("at most 64"));
    EXPECT_LE(ack.reason().size(), 300u);
  }
}

TEST_F(LimitsTest, ServingEndsAtOnceWhateverIdleClientsDo) {
  std::vector<std::shared_ptr<grpc::Channel>> idle;
  for (int i = 0; i < 20; ++i) {
    grpc::ChannelArguments arguments;
    arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
    idle.push_back(grpc::CreateCustomChannel(server_->address(), grpc::InsecureChannelCredentials(),
                                             arguments));
    v1::MapInfo info;
    EXPECT_GRPC_OK(Stubs(idle.back()).map->GetMapInfo(NewContext().get(), {}, &info));
  }
  OpenStream open(*stubs_), silent(*stubs_);
  ASSERT_TRUE(open.wire->Write(Naming(stubs_->NewSession("alice"))));
  ASSERT_TRUE(open.wire->Write(ScanOf(1)));
  v1::StreamScansResponse ack;
  ASSERT_TRUE(open.wire->Read(&ack));
  const auto begin = std::chrono::steady_clock::now();
  server_->Shutdown(std::chrono::seconds(10));
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(1));
}

// Limits of time that a test can wait for.
class ImpatientTest : public RpcTest {
 protected:
  static ServerOptions Impatient() {
    ServerOptions options;
    options.streams.first_message = std::chrono::milliseconds(50);
    options.streams.progress = std::chrono::milliseconds(600);
    options.calls.queries = 8;  // Two exports, one of a caller.
    return options;
  }
  ImpatientTest() : RpcTest(Impatient()) {}
};

TEST_F(ImpatientTest, AStreamOnWhichNothingComesIsEnded) {
  OpenStream scans(*stubs_);
  EXPECT_GRPC_ERROR(scans.Finish(), DEADLINE_EXCEEDED, "something to send");
  const auto upload_context = NewContext();
  v1::UploadSubmapResponse response;
  EXPECT_GRPC_ERROR(stubs_->sessions->UploadSubmap(upload_context.get(), &response)->Finish(),
                    DEADLINE_EXCEEDED, "something to send");
  const auto context = NewContext();
  const auto localisation = v1::LocalisationService::NewStub(channel_);
  EXPECT_GRPC_ERROR(localisation->Localise(context.get())->Finish(), DEADLINE_EXCEEDED,
                    "something to send");
}

TEST_F(ImpatientTest, AStreamOfScansMayPauseAsLongAsItLikes) {
  OpenStream scans(*stubs_);
  const std::string session = stubs_->NewSession("alice");
  ASSERT_TRUE(scans.wire->Write(Naming(session)));
  // Another one, opened later, runs into the limit meanwhile.
  OpenStream silent(*stubs_);
  EXPECT_FALSE(silent.Finish().ok());
  ASSERT_TRUE(scans.wire->Write(ScanOf(1)));
  v1::StreamScansResponse ack;
  EXPECT_TRUE(scans.wire->Read(&ack));
}

TEST_F(ImpatientTest, AnUploadThatStandsStillIsEnded) {
  const auto context = NewContext();
  v1::UploadSubmapResponse response;
  auto upload = stubs_->sessions->UploadSubmap(context.get(), &response);
  v1::UploadSubmapRequest part;
  part.mutable_header()->set_session(stubs_->NewSession("bob"));
  part.mutable_header()->set_size(100);
  ASSERT_TRUE(upload->Write(part));
  EXPECT_GRPC_ERROR(upload->Finish(), DEADLINE_EXCEEDED, "GetUpload");
}

TEST_F(ImpatientTest, AReaderThatDoesNotReadGivesUpItsPlace) {
  pipeline_.file.assign(40, std::string(1 << 20, 'x'));
  v1::ExportMapRequest request;
  request.set_format(v1::ExportMapRequest::PLY);
  const auto deaf_context = NewContext();
  const auto deaf = stubs_->map->ExportMap(deaf_context.get(), request);
  v1::ExportMapResponse response;
  ASSERT_TRUE(deaf->Read(&response));
  // It holds the one place of this caller until it is ended for not reading.
  grpc::Status status;
  int refused = 0;
  do {
    std::vector<v1::ExportMapResponse> all;
    const auto context = NewContext();
    status = ReadAll(stubs_->map->ExportMap(context.get(), request), &all);
    if (status.error_code() == grpc::StatusCode::RESOURCE_EXHAUSTED) ++refused;
  } while (status.error_code() == grpc::StatusCode::RESOURCE_EXHAUSTED &&
           std::chrono::system_clock::now() < deaf_context->deadline());
  EXPECT_GRPC_OK(status);
  EXPECT_GT(refused, 0);
  while (deaf->Read(&response)) {
  }
  EXPECT_EQ(deaf->Finish().error_code(), grpc::StatusCode::CANCELLED);
}

// Scans that wait are bounded in bytes.
class FewBytesTest : public RpcTest {
 protected:
  static ServerOptions FewBytes() {
    ServerOptions options;
    options.streams.all_bytes = 3'000'000;  // One stream has one scan.
    return options;
  }
  FewBytesTest() : RpcTest(FewBytes()) {}
};

TEST_F(FewBytesTest, LargeScansWaitOutsideOfTheServerAndTakeTurns) {
  pipeline_.Hold(1000);
  OpenStream first(*stubs_), second(*stubs_);
  ASSERT_TRUE(first.wire->Write(Naming(stubs_->NewSession("alice"))));
  ASSERT_TRUE(second.wire->Write(Naming(stubs_->NewSession("bob"))));
  std::thread writers[] = {std::thread([&] {
                             for (uint64_t i = 1; i <= 10; ++i)
                               first.wire->Write(ScanOf(i, 1'200'000));
                           }),
                           std::thread([&] {
                             for (uint64_t i = 1; i <= 10; ++i)
                               second.wire->Write(ScanOf(i, 1'200'000));
                           })};
  pipeline_.WaitForQueued(2);
  // Another call's round trip gives a further scan every chance to come through.
  v1::ListSessionsResponse list;
  EXPECT_GRPC_OK(Merged(stubs_->sessions->ListSessions(NewContext().get(), {}), &list));
  EXPECT_EQ(pipeline_.Waiting(), 2u);
  pipeline_.Release();
  for (OpenStream* stream : {&first, &second}) {
    v1::StreamScansResponse ack;
    for (uint64_t i = 1; i <= 10; ++i) {
      ASSERT_TRUE(stream->wire->Read(&ack));
      EXPECT_EQ(ack.sequence(), i);
    }
  }
  for (std::thread& writer : writers) writer.join();
}

// 128 rings of 2048 columns, in the 48 bytes that Ouster's driver gives each point.
TEST(DenseScanTest, FitsIntoAMessage) {
  EXPECT_LT(ScanOf(1, size_t{128} * 2048 * 48).ByteSizeLong(),
            static_cast<size_t>(ServerOptions().max_receive_bytes));
}

}  // namespace
}  // namespace isthmus::rpc
