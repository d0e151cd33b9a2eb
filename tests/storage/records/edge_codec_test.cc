#include "storage/records/edge_codec.h"

#include <gtest/gtest.h>

#include "core/io/crc32c.h"
#include "core/byte_stream.h"
#include "tests/storage/records.h"

namespace isthmus::storage {
namespace {

// As docs/storage-format.md has it.
TEST(EdgeCodec, HasTheDocumentedLayout) {
  SubmapEdge edge;
  edge.submap_a = 7;
  edge.submap_b = 3;
  edge.T_a_b = Pose(Eigen::Vector3d(1, 0, 0));
  edge.information.diagonal() << 1, 2, 3, 4, 5, 6;
  edge.information(0, 5) = edge.information(5, 0) = 9;
  const std::string blob = EncodeEdges({edge});
  ASSERT_EQ(blob.size(), 12u + 232u);
  EXPECT_EQ(blob.substr(0, 4), "IME1");
  const std::string rest = blob.substr(4);
  ByteReader reader(rest);
  EXPECT_EQ(reader.Read<uint32_t>(), io::Crc32c(blob.data() + 8, blob.size() - 8));
  EXPECT_EQ(reader.Read<uint32_t>(), 1u);
  EXPECT_EQ(reader.Read<uint32_t>(), 7u);
  EXPECT_EQ(reader.Read<uint32_t>(), 3u);
  const double pose[] = {0, 0, 0, 1, 1, 0, 0};
  for (const double value : pose) EXPECT_EQ(reader.Read<double>(), value);
  const double triangle[] = {1, 0, 0, 0, 0, 9, 2, 0, 0, 0, 0, 3, 0, 0, 0, 4, 0, 0, 5, 0, 6};
  for (const double value : triangle) EXPECT_EQ(reader.Read<double>(), value);
  EXPECT_TRUE(reader.ok());
  EXPECT_EQ(reader.remaining(), 0u);
}

TEST(EdgeCodec, NoticesEveryFlippedByteAndEveryTruncation) {
  const std::string blob = EncodeEdges({MakeEdge(1, 2), MakeEdge(3, 4)});
  std::vector<SubmapEdge> back;
  ASSERT_TRUE(DecodeEdges(blob, back).ok());
  EXPECT_EQ(back.size(), 2u);
  for (size_t i = 0; i < blob.size(); ++i) {
    std::string bad = blob;
    bad[i] = static_cast<char>(bad[i] ^ 0x20);
    ASSERT_EQ(DecodeEdges(bad, back).code(), absl::StatusCode::kDataLoss) << i;
    ASSERT_EQ(DecodeEdges(blob.substr(0, i), back).code(), absl::StatusCode::kDataLoss) << i;
  }
  EXPECT_FALSE(DecodeEdges(blob + '\0', back).ok());
}

// A checksum proves who wrote the bytes no more than that they arrived.
TEST(EdgeCodec, RefusesWhatIsNotFiniteOrTooMany) {
  SubmapEdge edge = MakeEdge(1, 2);
  edge.information(4, 4) = std::numeric_limits<double>::infinity();
  std::vector<SubmapEdge> back;
  EXPECT_FALSE(DecodeEdges(EncodeEdges({edge}), back).ok());
  std::string body;
  AppendBytes(uint32_t{0xffffffff}, body);
  std::string blob = "IME1";
  AppendBytes(io::Crc32c(body.data(), body.size()), blob);
  EXPECT_FALSE(DecodeEdges(blob + body, back).ok());
}

}  // namespace
}  // namespace isthmus::storage
