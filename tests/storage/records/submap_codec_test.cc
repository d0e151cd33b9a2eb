#include "storage/records/submap_codec.h"

#include <gtest/gtest.h>

#include "core/io/crc32c.h"
#include "core/byte_stream.h"
#include "tests/storage/records.h"

namespace isthmus::storage {
namespace {

// The worked example of docs/storage-format.md.
TEST(SubmapCodec, HasTheDocumentedLayout) {
  Submap submap;
  submap.keyframes.push_back({7, 1000, Pose(Eigen::Vector3d(1, 0, 0))});
  const auto blob = EncodeSubmap(submap, 0.001);
  ASSERT_TRUE(blob.ok()) << blob.status();
  ASSERT_EQ(blob->size(), 96u);
  EXPECT_EQ(blob->substr(0, 4), "ISM1");
  const std::string body = blob->substr(8);
  const std::string header = blob->substr(4);
  ByteReader reader(header);
  EXPECT_EQ(io::Crc32c(body.data(), body.size()), 0xc5e2ecd3u);
  EXPECT_EQ(reader.Read<uint32_t>(), 0xc5e2ecd3u);
  EXPECT_EQ(reader.Read<uint32_t>(), 1u);
  EXPECT_EQ(reader.Read<uint32_t>(), 0u);
  EXPECT_EQ(reader.Read<double>(), 0.001);
  EXPECT_EQ(reader.Read<uint64_t>(), 7u);
  EXPECT_EQ(reader.Read<int64_t>(), 1000);
  const double pose[] = {0, 0, 0, 1, 1, 0, 0};
  for (const double value : pose) EXPECT_EQ(reader.Read<double>(), value);
  EXPECT_TRUE(reader.ok());
  EXPECT_EQ(reader.remaining(), 0u);
}

TEST(SubmapCodec, RoundsToItsResolution) {
  const auto submap = MakeSubmap("alice-1", 4);
  for (const double resolution : {0.0001, 0.001, 0.05}) {
    const auto blob = EncodeSubmap(*submap, resolution);
    ASSERT_TRUE(blob.ok()) << blob.status();
    Submap back;
    ASSERT_TRUE(DecodeSubmap(*blob, back).ok());
    ASSERT_EQ(back.points.size(), submap->points.size());
    for (size_t i = 0; i < back.points.size(); ++i) {
      const Eigen::Vector3f error = back.points[i].Position() - submap->points[i].Position();
      EXPECT_LE(error.cwiseAbs().maxCoeff(), resolution / 2 + 1e-6);
    }
  }
  EXPECT_EQ(EncodeSubmap(*submap, 0).status().code(), absl::StatusCode::kInvalidArgument);
}

TEST(SubmapCodec, NoticesEveryFlippedByteAndEveryTruncation) {
  const auto blob = EncodeSubmap(*MakeSubmap("alice-1", 4, 60), 0.001);
  ASSERT_TRUE(blob.ok()) << blob.status();
  Submap back;
  for (size_t i = 0; i < blob->size(); ++i) {
    std::string bad = *blob;
    bad[i] = static_cast<char>(bad[i] ^ 0x20);
    ASSERT_EQ(DecodeSubmap(bad, back).code(), absl::StatusCode::kDataLoss) << i;
    ASSERT_EQ(DecodeSubmap(blob->substr(0, i), back).code(), absl::StatusCode::kDataLoss) << i;
  }
  EXPECT_EQ(DecodeSubmap(*blob + "x", back).code(), absl::StatusCode::kDataLoss);
}

// With the checksum made right again, so that what lies behind it is reached.
TEST(SubmapCodec, SurvivesForgeries) {
  const auto blob = EncodeSubmap(*MakeSubmap("alice-1", 4, 60), 0.001);
  ASSERT_TRUE(blob.ok()) << blob.status();
  const auto forge = [&](size_t at, uint32_t value) {
    std::string bad = *blob;
    std::memcpy(&bad[at], &value, 4);
    const uint32_t crc = io::Crc32c(&bad[8], bad.size() - 8);
    std::memcpy(&bad[4], &crc, 4);
    Submap back;
    return DecodeSubmap(bad, back).code();
  };
  for (const uint32_t lie : {0u, 1u, 0xFFFFFFFFu, 0x7FFFFFFFu, 3'999'999u}) {
    EXPECT_EQ(forge(8, lie), absl::StatusCode::kDataLoss) << "keyframes " << lie;
    EXPECT_EQ(forge(12, lie), absl::StatusCode::kDataLoss) << "points " << lie;
  }
  EXPECT_EQ(forge(20, 0xFFFFFFFF), absl::StatusCode::kDataLoss) << "resolution";
}

}  // namespace
}  // namespace isthmus::storage
