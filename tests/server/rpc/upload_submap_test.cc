// UploadSubmap over a socket: chunks, checksums, what a submap must hold.
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <limits>
#include <random>

#include "core/codec/quantized.h"
#include "core/io/crc32c.h"
#include "core/io/sha256.h"
#include "tests/server/rpc/rpc_fixture.h"

namespace isthmus::rpc {
namespace {

constexpr float kNotANumber = std::numeric_limits<float>::quiet_NaN();

struct Record {
  float x, y, z, intensity;
  uint32_t keyframe;
};

void AddField(const char* name, uint32_t offset, v1::PointField::Type type, v1::PointCloud& cloud) {
  v1::PointField& field = *cloud.add_fields();
  field.set_name(name);
  field.set_offset(offset);
  field.set_type(type);
}

// A submap's upload before it is cut into chunks.
struct Upload {
  v1::UploadSubmapHeader header;
  std::string data;

  void Seal() {
    header.set_size(data.size());
    header.set_crc32c(io::Crc32c(data.data(), data.size()));
  }
};

Upload MakeUpload(const std::string& session, const std::vector<Record>& records) {
  Upload upload;
  upload.header.set_session(session);
  upload.header.set_first_stamp_ns(100);
  upload.header.set_last_stamp_ns(900);
  upload.header.mutable_t_odom_submap()->mutable_translation()->set_x(4);
  for (int i = 0; i < 2; ++i) {
    v1::StampedPose& keyframe = *upload.header.add_keyframes();
    keyframe.set_stamp_ns(100 + 800 * i);
    keyframe.mutable_pose()->mutable_translation()->set_x(i);
  }
  v1::PointCloud& cloud = *upload.header.mutable_cloud();
  cloud.set_encoding(v1::PointCloud::RAW);
  cloud.set_width(static_cast<uint32_t>(records.size()));
  cloud.set_stride(sizeof(Record));
  AddField("x", 0, v1::PointField::FLOAT32, cloud);
  AddField("y", 4, v1::PointField::FLOAT32, cloud);
  AddField("z", 8, v1::PointField::FLOAT32, cloud);
  AddField("intensity", 12, v1::PointField::FLOAT32, cloud);
  AddField("keyframe", 16, v1::PointField::UINT32, cloud);
  upload.data.assign(reinterpret_cast<const char*>(records.data()),
                     records.size() * sizeof(Record));
  upload.Seal();
  return upload;
}

class UploadSubmapTest : public RpcTest {
 protected:
  UploadSubmapTest() : RpcTest(SmallLimit()), session_(stubs_->NewSession("bob")) {}

  static ServerOptions SmallLimit() {
    ServerOptions options;
    options.max_submap_bytes = 100'000;
    return options;
  }

  Upload Good() const { return MakeUpload(session_, {{1, 2, 3, 0.5F, 0}, {4, 5, 6, 0.25F, 1}}); }

  grpc::Status SendParts(const std::vector<v1::UploadSubmapRequest>& parts) {
    const auto context = NewContext();
    auto writer = stubs_->sessions->UploadSubmap(context.get(), &response_);
    for (const auto& part : parts) {
      if (!writer->Write(part)) break;
    }
    writer->WritesDone();
    return writer->Finish();
  }

  static v1::UploadSubmapRequest Header(const Upload& upload) {
    v1::UploadSubmapRequest part;
    *part.mutable_header() = upload.header;
    return part;
  }
  static v1::UploadSubmapRequest Chunk(uint64_t offset, const std::string& data) {
    v1::UploadSubmapRequest part;
    part.mutable_chunk()->set_offset(offset);
    part.mutable_chunk()->set_data(data);
    return part;
  }
  // In chunks of 7 bytes.
  grpc::Status Send(const Upload& upload) {
    std::vector<v1::UploadSubmapRequest> parts = {Header(upload)};
    for (size_t offset = 0; offset < upload.data.size(); offset += 7) {
      parts.push_back(Chunk(offset, upload.data.substr(offset, 7)));
    }
    return SendParts(parts);
  }

  const std::string session_;
  v1::UploadSubmapResponse response_;
};

TEST_F(UploadSubmapTest, ArrivesAsItWasSent) {
  EXPECT_GRPC_OK(Send(Good()));
  EXPECT_EQ(response_.session(), session_);
  EXPECT_EQ(response_.index(), 0u);
  EXPECT_EQ(response_.point_count(), 2u);
  ASSERT_EQ(pipeline_.submaps().size(), 1u);
  const Submap submap = pipeline_.submaps()[0];
  EXPECT_EQ(submap.robot.value(), "bob");
  EXPECT_EQ(submap.first_stamp_ns, 100);
  EXPECT_EQ(submap.last_stamp_ns, 900);
  EXPECT_EQ(submap.T_odom_submap.translation().x(), 4);
  ASSERT_EQ(submap.keyframes.size(), 2u);
  EXPECT_EQ(submap.keyframes[1].stamp_ns, 900);
  EXPECT_EQ(submap.keyframes[1].T_submap_sensor.translation().x(), 1);
  ASSERT_EQ(submap.points.size(), 2u);
  EXPECT_EQ(submap.points[1].Position(), Eigen::Vector3f(4, 5, 6));
  EXPECT_EQ(submap.points[1].intensity, 0.25F);
  EXPECT_EQ(submap.points[1].keyframe, 1);
}

TEST_F(UploadSubmapTest, WithoutKeyframesTheSensorStoodAtTheOrigin) {
  Upload upload = MakeUpload(session_, {{1, 2, 3, 0, 0}});
  upload.header.clear_keyframes();
  EXPECT_GRPC_OK(Send(upload));
  const Submap submap = pipeline_.submaps().at(0);
  ASSERT_EQ(submap.keyframes.size(), 1u);
  EXPECT_EQ(submap.keyframes[0].T_submap_sensor.translation().norm(), 0);
  EXPECT_EQ(submap.keyframes[0].stamp_ns, 900);
}

TEST_F(UploadSubmapTest, AQuantizedCloudArrivesWithinItsResolution) {
  Upload upload = Good();
  PointPayload raw;
  raw.width = 2;
  raw.stride = sizeof(Record);
  raw.fields = {{"x", 0, ScalarType::kFloat32, 1},
                {"y", 4, ScalarType::kFloat32, 1},
                {"z", 8, ScalarType::kFloat32, 1},
                {"intensity", 12, ScalarType::kFloat32, 1},
                {"keyframe", 16, ScalarType::kUint32, 1}};
  raw.data = upload.data;
  const auto quantized = codec::Quantize(raw, 0.002);
  ASSERT_TRUE(quantized.ok()) << quantized.status();
  upload.data = quantized->data;
  upload.header.mutable_cloud()->set_encoding(v1::PointCloud::QUANTIZED);
  upload.header.mutable_cloud()->set_resolution_m(0.002);
  upload.Seal();
  EXPECT_GRPC_OK(Send(upload));
  const Submap submap = pipeline_.submaps().at(0);
  EXPECT_NEAR(submap.points.at(1).y, 5, 0.001);
  EXPECT_EQ(submap.points[1].keyframe, 1);
}

TEST_F(UploadSubmapTest, PartsOutOfPlaceAreRefused) {
  const Upload good = Good();
  EXPECT_GRPC_ERROR(SendParts({}), INVALID_ARGUMENT, "before its header");
  EXPECT_GRPC_ERROR(SendParts({Chunk(0, good.data)}), INVALID_ARGUMENT, "must be its header");
  EXPECT_GRPC_ERROR(SendParts({v1::UploadSubmapRequest()}), INVALID_ARGUMENT, "header");
  EXPECT_GRPC_ERROR(SendParts({Header(good), Header(good)}), INVALID_ARGUMENT, "second header");
  EXPECT_GRPC_ERROR(SendParts({Header(good), Chunk(4, good.data)}), OUT_OF_RANGE,
                    "offset 0 is expected");
  EXPECT_GRPC_ERROR(SendParts({Header(good), Chunk(0, good.data + "x")}), OUT_OF_RANGE,
                    "runs past");
  EXPECT_TRUE(pipeline_.submaps().empty());
  EXPECT_GRPC_OK(Send(good));
}

TEST_F(UploadSubmapTest, DamageOnTheWayIsDataLoss) {
  Upload upload = Good();
  EXPECT_GRPC_ERROR(SendParts({Header(upload), Chunk(0, upload.data.substr(0, 10))}), DATA_LOSS,
                    "10 of 40 bytes");
  upload.data[3] ^= 1;
  EXPECT_GRPC_ERROR(Send(upload), DATA_LOSS, "crc32c");
  EXPECT_TRUE(pipeline_.submaps().empty());
}

TEST_F(UploadSubmapTest, TooLargeIsRefusedByTheHeaderAlone) {
  Upload upload = Good();
  upload.header.set_size(100'001);
  EXPECT_GRPC_ERROR(SendParts({Header(upload)}), RESOURCE_EXHAUSTED, "larger than the server");
}

TEST_F(UploadSubmapTest, UnknownSession) {
  EXPECT_GRPC_ERROR(Send(MakeUpload("nobody-1", {{1, 2, 3, 0, 0}})), NOT_FOUND, "nobody-1");
}

TEST_F(UploadSubmapTest, AnIntensityThatIsNoneIsZero) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  EXPECT_GRPC_OK(Send(MakeUpload(session_, {{1, 2, 3, kNotANumber, 0}, {4, 5, 6, kInfinity, 1}})));
  const std::vector<Submap> submaps = pipeline_.submaps();
  ASSERT_EQ(submaps.size(), 1u);
  for (const SubmapPoint& point : submaps[0].points) EXPECT_EQ(point.intensity, 0);
}

TEST_F(UploadSubmapTest, OfTwoCallsForOneSubmapTheNewerEndsTheOther) {
  ServerOptions options = SmallLimit();
  options.listen = "127.0.0.1:0";
  options.uploads_folder = testing::TempDir() + "isthmus_upload_two_" + std::to_string(getpid());
  std::filesystem::remove_all(options.uploads_folder);
  server_ = *RpcServer::Start(&pipeline_, options);
  stubs_ = std::make_unique<Stubs>(
      grpc::CreateChannel(server_->address(), grpc::InsecureChannelCredentials()));
  const Upload upload = Good();
  const auto context = NewContext();
  v1::UploadSubmapResponse nothing;
  auto older = stubs_->sessions->UploadSubmap(context.get(), &nothing);
  older->Write(Header(upload));
  older->Write(Chunk(0, upload.data.substr(0, 7)));
  v1::GetUploadRequest question;
  question.set_session(session_);
  question.set_size(upload.header.size());
  question.set_crc32c(upload.header.crc32c());
  v1::GetUploadResponse known;
  while (known.persisted() < 7 && context->deadline() > std::chrono::system_clock::now()) {
    ASSERT_GRPC_OK(stubs_->sessions->GetUpload(NewContext().get(), question, &known));
  }
  EXPECT_GRPC_OK(Send(upload));
  EXPECT_GRPC_ERROR(older->Finish(), ABORTED, "another call");
  server_.reset();
  std::filesystem::remove_all(options.uploads_folder);
}

TEST_F(UploadSubmapTest, AHashThatIsNoneIsRefused) {
  Upload upload = Good();
  upload.header.set_sha256(std::string(100'000, 'x'));
  EXPECT_GRPC_ERROR(Send(upload), INVALID_ARGUMENT, "at most 32");
  v1::GetUploadRequest ask;
  ask.set_session(session_);
  ask.set_sha256("x");
  v1::GetUploadResponse arrived;
  EXPECT_GRPC_ERROR(stubs_->sessions->GetUpload(NewContext().get(), ask, &arrived),
                    INVALID_ARGUMENT, "32 bytes");
}

TEST_F(UploadSubmapTest, CloudsThatCannotBeUsed) {
  Upload upload = MakeUpload(session_, {});
  EXPECT_GRPC_ERROR(Send(upload), INVALID_ARGUMENT, "no points");
  EXPECT_GRPC_ERROR(Send(MakeUpload(session_, {{1, kNotANumber, 3, 0, 0}})), INVALID_ARGUMENT,
                    "point 0");
  EXPECT_GRPC_ERROR(Send(MakeUpload(session_, {{1, 1, 3e6F, 0, 0}})), INVALID_ARGUMENT, "5 km");
  EXPECT_GRPC_ERROR(Send(MakeUpload(session_, {{1, 1, -5001, 0, 0}})), INVALID_ARGUMENT, "5 km");
  EXPECT_GRPC_ERROR(Send(MakeUpload(session_, {{1, 1, 3, 0, 2}})), INVALID_ARGUMENT,
                    "names keyframe 2");

  upload = Good();
  upload.header.mutable_cloud()->mutable_fields(2)->set_name("height");
  EXPECT_GRPC_ERROR(Send(upload), INVALID_ARGUMENT, "\"z\"");

  upload = Good();
  upload.header.mutable_cloud()->mutable_fields(4)->set_type(v1::PointField::FLOAT32);
  EXPECT_GRPC_ERROR(Send(upload), INVALID_ARGUMENT, "uint8, uint16 or uint32");

  upload = Good();
  upload.header.mutable_cloud()->set_width(4'000'000'000U);
  EXPECT_GRPC_ERROR(Send(upload), INVALID_ARGUMENT, "is limited to");

  upload = Good();
  upload.header.mutable_cloud()->set_encoding(v1::PointCloud::QUANTIZED);
  EXPECT_GRPC_ERROR(Send(upload), INVALID_ARGUMENT, "resolution");
  upload.header.mutable_cloud()->set_resolution_m(0.001);
  EXPECT_GRPC_ERROR(Send(upload), INVALID_ARGUMENT, "quantised");

  upload = Good();
  upload.header.mutable_cloud()->set_encoding(v1::PointCloud::DRACO);
  EXPECT_GRPC_ERROR(Send(upload), INVALID_ARGUMENT, "takes none: give RAW or QUANTIZED");

  upload = Good();
  upload.header.mutable_cloud()->clear_encoding();
  EXPECT_GRPC_ERROR(Send(upload), INVALID_ARGUMENT, "RAW or QUANTIZED");
  EXPECT_TRUE(pipeline_.submaps().empty());
}

TEST_F(UploadSubmapTest, PosesThatCannotBeUsed) {
  Upload upload = Good();
  upload.header.mutable_t_odom_submap()->mutable_translation()->set_x(kNotANumber);
  EXPECT_GRPC_ERROR(Send(upload), INVALID_ARGUMENT, "t_odom_submap");
  upload = Good();
  upload.header.mutable_keyframes(1)->mutable_pose()->mutable_rotation();
  EXPECT_GRPC_ERROR(Send(upload), INVALID_ARGUMENT, "keyframes.pose");
}

TEST_F(UploadSubmapTest, GoesOnBehindWhatArrivedThroughRestartsOfTheServer) {
  ServerOptions options = SmallLimit();
  options.listen = "127.0.0.1:0";
  options.uploads_folder = testing::TempDir() + "isthmus_upload_rpc_" + std::to_string(getpid());
  std::filesystem::remove_all(options.uploads_folder);
  std::vector<Record> records;
  for (int i = 0; i < 4000; ++i) {
    records.push_back({static_cast<float>(i), 1, 2, 0.5F, static_cast<uint32_t>(i % 2)});
  }
  const Upload upload = MakeUpload(session_, records);
  v1::GetUploadRequest question;
  question.set_session(session_);
  question.set_size(upload.header.size());
  question.set_crc32c(upload.header.crc32c());
  std::mt19937 random(11);
  int calls = 0;
  for (bool done = false; !done; ++calls) {
    server_ = *RpcServer::Start(&pipeline_, options);
    stubs_ = std::make_unique<Stubs>(
        grpc::CreateChannel(server_->address(), grpc::InsecureChannelCredentials()));
    v1::GetUploadResponse known;
    EXPECT_GRPC_OK(stubs_->sessions->GetUpload(NewContext().get(), question, &known));
    std::vector<v1::UploadSubmapRequest> parts = {Header(upload)};
    size_t offset = known.persisted();
    for (int chunks = static_cast<int>(random() % 5); chunks > 0; --chunks) {
      const std::string data = upload.data.substr(offset, 1 + random() % 9000);
      if (data.empty()) break;
      parts.push_back(Chunk(offset, data));
      offset += data.size();
    }
    const grpc::Status status = SendParts(parts);
    done = status.ok();
    EXPECT_EQ(done, offset == upload.data.size());
    if (!done) EXPECT_GRPC_ERROR(status, DATA_LOSS, "send the rest");
  }
  EXPECT_GT(calls, 2);
  ASSERT_EQ(pipeline_.submaps().size(), 1u);
  const Submap submap = pipeline_.submaps()[0];
  ASSERT_EQ(submap.points.size(), records.size());
  for (size_t i = 0; i < records.size(); ++i) EXPECT_EQ(submap.points[i].x, records[i].x);
  EXPECT_TRUE(std::filesystem::is_empty(options.uploads_folder));
  std::filesystem::remove_all(options.uploads_folder);
}

TEST_F(UploadSubmapTest, BytesThatAreNotWhatTheirNameSays) {
  Upload upload = Good();
  upload.header.set_sha256(std::string(32, 'x'));
  EXPECT_GRPC_ERROR(Send(upload), DATA_LOSS, "sha256");
  upload.header.set_sha256(io::Sha256(upload.data.data(), upload.data.size()));
  EXPECT_GRPC_OK(Send(upload));
}

}  // namespace
}  // namespace isthmus::rpc
