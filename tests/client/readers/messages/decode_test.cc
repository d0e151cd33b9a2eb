// Messages that are damaged, or as only some drivers write them.
#include <cmath>
#include <cstring>
#include <functional>

#include "client/readers/messages/decode/cloud_message.h"
#include "client/readers/messages/decode/packet_message.h"
#include "client/readers/messages/decode/place_message.h"
#include "tests/client/readers/messages/damage_helpers.h"

namespace isthmus::readers {
namespace {

using namespace std::string_literals;

using testing::HasSubstr;

// Serialises as ROS 1 does, or as CDR in either byte order.
class Writer {
 public:
  enum class As { kRos1, kCdrLittle, kCdrBig };
  explicit Writer(As as) : as_(as) {
    if (as_ != As::kRos1)
      bytes_ = std::string("\0", 1) + (as == As::kCdrBig ? '\0' : '\1') + "\0\0"s;
  }
  template <typename T>
  Writer& Add(T value) {
    while (as_ != As::kRos1 && (bytes_.size() - 4) % sizeof(T) != 0) bytes_ += '\0';
    std::string number(reinterpret_cast<const char*>(&value), sizeof(T));
    if (as_ == As::kCdrBig) std::reverse(number.begin(), number.end());
    bytes_ += number;
    return *this;
  }
  Writer& Text(const std::string& text) {
    const std::string all = as_ == As::kRos1 ? text : text + '\0';
    Add(static_cast<uint32_t>(all.size()));
    bytes_ += all;
    return *this;
  }
  Writer& Header(int sec, uint32_t ns) {
    if (as_ == As::kRos1) Add(uint32_t{9});
    return Add(sec).Add(ns).Text("f");
  }
  Writer& Raw(const std::string& raw) {
    bytes_ += raw;
    return *this;
  }
  const char* encoding() const { return as_ == As::kRos1 ? "ros1" : "cdr"; }
  const std::string& bytes() const { return bytes_; }

 private:
  const As as_;
  std::string bytes_;
};

struct CloudOf {
  uint32_t height = 1, width = 2, step = 12, row_step = 24, count = 1;
  uint8_t type = 7;
  std::string data = std::string(24, '\1');
};

Writer WriteCloud(Writer::As as, const CloudOf& cloud) {
  Writer writer(as);
  writer.Header(5, 6).Add(cloud.height).Add(cloud.width).Add(uint32_t{4});
  for (const char* name : {"x", "y", "z"}) {
    writer.Text(name).Add(static_cast<uint32_t>(4 * (name[0] - 'x'))).Add(uint8_t{7});
    writer.Add(cloud.count);
  }
  writer.Text("extra").Add(uint32_t{0}).Add(cloud.type).Add(uint32_t{1});
  writer.Add(uint8_t{0}).Add(cloud.step).Add(cloud.row_step);
  writer.Add(static_cast<uint32_t>(cloud.data.size())).Raw(cloud.data).Add(uint8_t{1});
  return writer;
}

class DecodeTest : public testing::TestWithParam<Writer::As> {
 protected:
  absl::StatusOr<CloudMessage> Decode(const CloudOf& cloud) const {
    const Writer writer = WriteCloud(GetParam(), cloud);
    return DecodePointCloud2(writer.encoding(), writer.bytes());
  }
};

TEST_P(DecodeTest, CloudsAsSomeDriversWriteThem) {
  const auto plain = Decode({});
  ASSERT_TRUE(plain.ok()) << plain.status();
  EXPECT_EQ(plain->header.stamp_ns, 5'000'000'006);
  EXPECT_EQ(plain->header.frame, "f");
  EXPECT_EQ(plain->payload.fields.size(), 4u);
  EXPECT_TRUE(Decode({.row_step = 0}).ok());   // Left out where rows are not padded.
  EXPECT_TRUE(Decode({.row_step = 99}).ok());  // Or wrong.
  const auto zero = Decode({.count = 0});
  ASSERT_TRUE(zero.ok()) << zero.status();
  EXPECT_EQ(zero->payload.fields[0].count, 1u);
  const auto unknown = Decode({.type = 77});
  ASSERT_TRUE(unknown.ok());
  EXPECT_EQ(unknown->payload.fields.size(), 3u);
}

TEST_P(DecodeTest, CloudsThatCannotBeAreRefused) {
  EXPECT_THAT(std::string(Decode({.height = 0}).status().message()), HasSubstr("empty"));
  EXPECT_FALSE(Decode({.width = 3}).ok());
  EXPECT_FALSE(Decode({.height = 0xFFFFFFFF, .width = 0xFFFFFFFF}).ok());
  EXPECT_FALSE(Decode({.height = 0xFFFFFFFF, .step = 0}).ok());
  EXPECT_FALSE(Decode({.step = 8}).ok());
  EXPECT_FALSE(Decode({.count = 0xFFFFFFFF}).ok());
  // The bytes of all rows are 2^64, which is 0 in 64 bits.
  EXPECT_FALSE(Decode({.height = 1 << 20, .width = 1 << 20, .step = 1 << 24, .data = ""}).ok());
  EXPECT_FALSE(
      Decode({.height = 2, .width = 1, .row_step = 0xFFFFFFFF, .data = "1234567890123"}).ok());
}

TEST_P(DecodeTest, MessagesThatEndTooEarlyAreRefused) {
  const std::string fix = [&] {
    Writer writer(GetParam());
    writer.Header(1, 2).Add(int8_t{0}).Add(uint16_t{1}).Add(48.0).Add(11.0).Add(500.0);
    for (int i = 0; i < 9; ++i) writer.Add(1.0);
    return writer.Add(uint8_t{2}).bytes();
  }();
  const std::string cloud = WriteCloud(GetParam(), {}).bytes();
  const char* const encoding = Writer(GetParam()).encoding();
  EXPECT_TRUE(DecodeNavSatFix(encoding, fix, 0)->has_value());
  for (size_t size = 0; size < fix.size(); ++size) {
    EXPECT_FALSE(DecodeNavSatFix(encoding, absl::string_view(fix).substr(0, size), 0).ok()) << size;
  }
  for (size_t size = 0; size + 1 < cloud.size(); ++size) {
    const absl::string_view cut = absl::string_view(cloud).substr(0, size);
    EXPECT_FALSE(DecodePointCloud2(encoding, cut).ok()) << size;
    EXPECT_FALSE(DecodeLivox(encoding, cut).ok()) << size;
    EXPECT_FALSE(DecodePacketList(PacketList::kVelodyneScan, encoding, cut, 0).ok() && size < 16)
        << size;
  }
}

// Two packets in a list: of fixed room, of as many bytes as they have, or without stamps.
TEST_P(DecodeTest, ListsOfPacketsAreReadAsTheirDriversWriteThem) {
  const auto write = [](PacketList list) {
    Writer writer(GetParam());
    writer.Header(5, 0).Add(uint32_t{2});
    for (const uint32_t size : {3, 5}) {
      const std::string data(size, static_cast<char>('a' + size));
      const bool sized = list == PacketList::kNebulaPackets || list == PacketList::kUdpFrame;
      if (list != PacketList::kUdpFrame) writer.Add(int32_t{7}).Add(size);
      if (sized) writer.Add(size);
      writer.Raw(sized ? data : data + std::string(1500 - size, '\0'));
      if (list != PacketList::kNebulaPackets) writer.Add(size);
    }
    return writer.bytes();
  };
  const char* const encoding = Writer(GetParam()).encoding();
  for (const PacketList list :
       {PacketList::kPandarScan, PacketList::kNebulaPackets, PacketList::kUdpFrame}) {
    const std::string bytes = write(list);
    const auto packets = DecodePacketList(list, encoding, bytes, 9);
    ASSERT_TRUE(packets.ok()) << packets.status();
    ASSERT_EQ(packets->size(), 2u);
    EXPECT_EQ((*packets)[0].bytes, "ddd");
    EXPECT_EQ((*packets)[1].bytes, "fffff");
    EXPECT_EQ((*packets)[1].frame, "f");
    EXPECT_EQ((*packets)[1].arrival_ns,
              list == PacketList::kUdpFrame ? 5'000'000'000 : 7'000'000'005);
    for (size_t size = 0; size < bytes.size(); ++size) {
      const absl::string_view cut = absl::string_view(bytes).substr(0, size);
      EXPECT_FALSE(DecodePacketList(list, encoding, cut, 9).ok()) << size;
    }
  }
}

TEST_P(DecodeTest, ATransformNeedsARotation) {
  const auto decode = [&](double w, double x) {
    Writer writer(GetParam());
    writer.Add(uint32_t{1}).Header(1, 2).Text("child").Add(x).Add(0.0).Add(0.0);
    writer.Add(0.0).Add(0.0).Add(0.0).Add(w);
    return DecodeTransforms(writer.encoding(), writer.bytes());
  };
  ASSERT_TRUE(decode(2, 1).ok()) << decode(2, 1).status();
  EXPECT_EQ(decode(2, 1)->at(0).T_parent_child.rotation().w(), 1);
  EXPECT_EQ(decode(2, 1)->at(0).parent, "f");
  EXPECT_THAT(std::string(decode(0, 1).status().message()), HasSubstr("'child' to 'f'"));
  EXPECT_FALSE(decode(1, std::numeric_limits<double>::quiet_NaN()).ok());
}

INSTANTIATE_TEST_SUITE_P(All, DecodeTest,
                         testing::Values(Writer::As::kRos1, Writer::As::kCdrLittle,
                                         Writer::As::kCdrBig));

TEST(FieldReaderTest, OtherRepresentationsAreNamed) {
  const auto other = FieldReader::Cdr("\0\x07\0\0 and so on"s);
  EXPECT_THAT(std::string(other.status().message()), HasSubstr("0x0007"));
  EXPECT_FALSE(FieldReader::Cdr("\0\1").ok());
  EXPECT_FALSE(OpenFields("json", "{}").ok());
}

// Fields of a protobuf message.
std::string Bytes(uint32_t number, const std::string& bytes) {
  return std::string(1, static_cast<char>(number << 3 | 2)) + static_cast<char>(bytes.size()) +
         bytes;
}
template <typename T>
std::string Fixed(uint32_t number, T value) {
  const uint32_t wire = sizeof(T) == 8 ? 1 : 5;
  return std::string(1, static_cast<char>(number << 3 | wire)) +
         std::string(reinterpret_cast<const char*>(&value), sizeof(T));
}

std::string FoxgloveCloud(const std::string& pose, const std::vector<float>& values) {
  std::string cloud = Bytes(2, "lidar") + pose + Fixed(4, uint32_t{12});
  for (uint32_t k = 0; k < 3; ++k) {
    const std::string type = "\x18\x07";  // FLOAT32
    cloud += Bytes(5, Bytes(1, std::string(1, "xyz"[k])) + Fixed(2, 4 * k) + type);
  }
  return cloud + Bytes(6, std::string(reinterpret_cast<const char*>(values.data()),
                                      values.size() * sizeof(float)));
}

TEST(DecodeTest, ThePoseOfAFoxgloveCloudIsApplied) {
  const double half = std::sqrt(0.5);  // A quarter turn about z.
  const std::string pose = Bytes(3, Bytes(1, Fixed(1, 100.0) + Fixed(2, 200.0) + Fixed(3, 3.0)) +
                                        Bytes(2, Fixed(3, half) + Fixed(4, half)));
  const std::vector<float> values = {1, 2, 0.5F, 0, 0, 0};  // The second is no return.
  const auto moved = DecodeFoxglove(FoxgloveCloud(pose, values));
  ASSERT_TRUE(moved.ok()) << moved.status();
  std::vector<float> read(6);
  std::memcpy(read.data(), moved->payload.data.data(), 24);
  EXPECT_THAT(read, testing::Pointwise(testing::FloatNear(1e-4F),
                                       std::vector<float>{98, 201, 3.5F, 0, 0, 0}));
  const auto still = DecodeFoxglove(FoxgloveCloud("", values));
  ASSERT_TRUE(still.ok()) << still.status();
  EXPECT_EQ(std::memcmp(still->payload.data.data(), values.data(), 24), 0);
  const std::string wrong = Bytes(3, Bytes(2, Fixed(4, 1e-9)));
  EXPECT_TRUE(absl::IsInvalidArgument(DecodeFoxglove(FoxgloveCloud(wrong, values)).status()));
}

}  // namespace
}  // namespace isthmus::readers
