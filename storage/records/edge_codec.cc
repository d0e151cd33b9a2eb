#include "storage/records/edge_codec.h"

#include "core/byte_stream.h"
#include "core/io/crc32c.h"
#include "storage/records/matrix_codec.h"
#include "storage/records/pose_codec.h"

namespace isthmus::storage {
namespace {

// The last character is the version of the layout.
constexpr char kEdgeMagic[] = "IME1";
constexpr size_t kEdgeMagicSize = 4;
constexpr size_t kEdgeSize = 2 * 4 + 7 * 8 + kSymmetricSize;

}  // namespace

std::string EncodeEdges(const std::vector<SubmapEdge>& edges) {
  std::string body;
  body.reserve(sizeof(uint32_t) + edges.size() * kEdgeSize);
  AppendBytes(static_cast<uint32_t>(edges.size()), body);
  for (const SubmapEdge& edge : edges) {
    AppendBytes(edge.submap_a, body);
    AppendBytes(edge.submap_b, body);
    AppendPose(edge.T_a_b, body);
    AppendSymmetric(edge.information, body);
  }
  std::string blob(kEdgeMagic, kEdgeMagicSize);
  AppendBytes(io::Crc32c(body.data(), body.size()), blob);
  return blob + body;
}

absl::Status DecodeEdges(const std::string& blob, std::vector<SubmapEdge>& edges) {
  constexpr size_t kBody = kEdgeMagicSize + sizeof(uint32_t);
  if (blob.size() < kBody || blob.compare(0, kEdgeMagicSize, kEdgeMagic) != 0) {
    return absl::DataLossError("they do not begin like edges");
  }
  ByteReader reader(blob);
  reader.Read<uint32_t>();
  if (reader.Read<uint32_t>() != io::Crc32c(blob.data() + kBody, blob.size() - kBody)) {
    return absl::DataLossError("their checksum is wrong");
  }
  const auto count = reader.Read<uint32_t>();
  if (!reader.ok() || reader.remaining() != uint64_t{count} * kEdgeSize) {
    return absl::DataLossError("they are not as many as they say");
  }
  edges.clear();
  edges.reserve(count);
  for (uint32_t i = 0; i < count; ++i) {
    SubmapEdge edge;
    edge.submap_a = reader.Read<uint32_t>();
    edge.submap_b = reader.Read<uint32_t>();
    edge.T_a_b = ReadPose(reader);
    edge.information = ReadSymmetric(reader);
    if (!edge.T_a_b.IsFinite() || !edge.information.allFinite()) {
      return absl::DataLossError("one of them is not finite");
    }
    edges.push_back(edge);
  }
  return absl::OkStatus();
}

}  // namespace isthmus::storage
