// Features that only one kind of container has.
#include <cstring>
#include <string>
#include <vector>

#include "client/readers/messages/unpack.h"
#include "tests/client/readers/messages/damage_helpers.h"

namespace isthmus::readers {
namespace {

using namespace std::string_literals;

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

std::string ErrorOf(const std::string& bytes, const std::string& name = "drive") {
  return std::string(OpenMessageBytes(BufferSource(bytes), name).status().message());
}

TEST(BagFileTest, ARecordingThatWasNotEndedIsReadByItsChunks) {
  std::string bytes = LoadData("drive_none.bag");
  const AllMessages whole = ReadBytes(bytes);
  const size_t field = bytes.find("index_pos=");
  ASSERT_NE(field, std::string::npos);
  uint64_t index_pos = 0;
  std::memcpy(&index_pos, &bytes[field + 10], 8);
  std::memset(&bytes[field + 10], 0, 8);
  bytes.resize(index_pos);
  const AllMessages active = ReadBytes(bytes);
  EXPECT_EQ(active.messages, whole.messages);
  EXPECT_THAT(active.errors, IsEmpty());
  EXPECT_THAT(active.notes, ElementsAre(HasSubstr("was not ended")));
}

// Messages of each topic, read alone, which passes over the chunks that hold none of it.
std::vector<size_t> CountEachTopic(const std::string& bytes) {
  const auto file = OpenMessageBytes(BufferSource(bytes), "drive");
  EXPECT_TRUE(file.ok()) << file.status();
  std::vector<size_t> counts;
  for (size_t topic = 0; file.ok() && topic < (*file)->topics().size(); ++topic) {
    counts.push_back(0);
    auto reader = (*file)->OpenReader({topic});
    EXPECT_TRUE(reader.ok()) << reader.status();
    while (reader.ok()) {
      const auto message = (*reader)->Next();
      EXPECT_TRUE(message.ok()) << message.status();
      if (!message.ok() || !message->has_value()) break;
      ++counts.back();
    }
  }
  return counts;
}

// The chunks stand twice in the bag, so that the second time all topics are known before them.
TEST(BagFileTest, AnIndexRecordThatCountsTooManyCostsNoMessage) {
  std::string bytes = LoadData("drive_none.bag");
  const size_t field = bytes.find("index_pos=") + 10;
  uint64_t index_pos = 0;
  std::memcpy(&index_pos, &bytes[field], 8);
  std::memset(&bytes[field], 0, 8);
  bytes.resize(index_pos);
  bytes += bytes.substr(bytes.find("compression=none") - 16);
  const std::vector<size_t> whole = CountEachTopic(bytes);
  size_t records = 0;
  for (size_t at = bytes.find("op=\x04", index_pos); at != std::string::npos;
       at = bytes.find("op=\x04", at)) {
    at = bytes.find("count=", at) + 6;
    std::string damaged = bytes;
    damaged[at + 2] = '\x7F';
    EXPECT_EQ(CountEachTopic(damaged), whole) << "byte " << at;
    ++records;
  }
  EXPECT_EQ(records, 19u);
}

TEST(BagFileTest, TheChunkThatIsBeingWrittenIsRead) {
  std::string bytes = LoadData("drive_none.bag");
  const AllMessages whole = ReadBytes(bytes);
  // Its sizes are filled in when it ends; until then it goes on to the end of the file.
  const size_t last = bytes.rfind("compression=none");
  const size_t size_field = bytes.find("size=", last);
  uint32_t chunk_size = 0;
  std::memcpy(&chunk_size, &bytes[size_field + 9], 4);
  std::memset(&bytes[size_field + 5], 0, 8);
  bytes.resize(size_field + 13 + chunk_size);
  const AllMessages active = ReadBytes(bytes);
  EXPECT_EQ(active.messages, whole.messages);
  EXPECT_THAT(active.errors, IsEmpty());
}

TEST(BagFileTest, WhatIsNotReadIsSaid) {
  EXPECT_THAT(ErrorOf("#ROSBAG V1.2\n and so on"), HasSubstr("rosbag migrate"));
  EXPECT_THAT(ErrorOf("anything else"), HasSubstr("neither a ROS bag nor MCAP"));
  EXPECT_THAT(ErrorOf(""), HasSubstr("neither a ROS bag nor MCAP"));
  EXPECT_THAT(ErrorOf("\x28\xB5\x2F\xFD and so on", "a.db3.zstd"), HasSubstr("zstd -d a.db3.zstd"));
  const std::string head = "\x04\0\0\0op=\x03\x14\0\0\0encryptor=rosbag/Aes"s;
  std::string bytes = "#ROSBAG V2.0\n";
  const auto append = [&](uint32_t value) {
    bytes.append(reinterpret_cast<const char*>(&value), 4);
  };
  append(static_cast<uint32_t>(head.size()));
  bytes += head;
  append(0);
  EXPECT_THAT(ErrorOf(bytes), HasSubstr("rosbag decrypt"));
}

TEST(McapFileTest, AFileOfLooseMessagesIsReadAsFarAsItGoes) {
  const std::string bytes = LoadData("drive_loose.mcap");
  const AllMessages whole = ReadBytes(bytes);
  EXPECT_EQ(whole.messages.size(), 20u);
  EXPECT_THAT(whole.notes, IsEmpty());
  const AllMessages half = ReadBytes(bytes.substr(0, bytes.size() / 2));
  EXPECT_GT(CountKept(whole.messages, half.messages), 5u);
  EXPECT_FALSE(half.notes.empty());
}

TEST(McapFileTest, ASummaryWithAWrongCrcIsNotBelieved) {
  std::string bytes = LoadData("drive_zstd.mcap");
  const AllMessages whole = ReadBytes(bytes);
  bytes[bytes.size() - 60] ^= 1;
  const AllMessages scanned = ReadBytes(bytes);
  EXPECT_EQ(scanned.messages, whole.messages);
  EXPECT_THAT(scanned.notes, ElementsAre(HasSubstr("CRC of the summary")));
}

TEST(McapFileTest, Ros1AndProtobufMessagesAreScansToo) {
  auto ros1 = OpenMessageRecording(DataFile("ros1.mcap"), {});
  ASSERT_TRUE(ros1.ok()) << ros1.status();
  const ReadAll a = ReadTopic(**ros1, "/a/points");
  ASSERT_EQ(a.scans.size(), 3u);
  for (int k = 0; k < 3; ++k) ExpectScanA(a.scans[k], k);
  auto foxglove = OpenMessageRecording(DataFile("foxglove.mcap"), {});
  ASSERT_TRUE(foxglove.ok()) << foxglove.status();
  EXPECT_EQ((*foxglove)->scan_topics()[0].type, "foxglove.PointCloud");
  const ReadAll fox = ReadTopic(**foxglove, "/fox");
  ASSERT_EQ(fox.scans.size(), 2u) << testing::PrintToString(fox.errors);
  for (int k = 0; k < 2; ++k) {
    const RecordedScan& scan = fox.scans[k];
    EXPECT_EQ(scan.end_stamp_ns, kDriveStartNs + (k + 1) * 100'000'000);
    // The messages' pose lies at x = 5; a point at the origin is no return.
    EXPECT_EQ(Column(scan.payload, "x"),
              EachPoint(3, [&](int i) { return i + k == 0 ? 0 : 5 + i + k; }));
    EXPECT_EQ(Column(scan.payload, "z"), EachPoint(3, [](int i) { return 3 * i; }));
    EXPECT_EQ(Column(scan.payload, "ring"), EachPoint(3, [](int i) { return i; }));
    EXPECT_EQ(Column(scan.payload, "t"), EachPoint(3, [](int i) { return 50'000'000.0 * i; }));
  }
}

TEST(MessageRecordingTest, PacketsNeedADecoder) {
  auto recording = OpenMessageRecording(DataFile("drive_none.bag"), {});
  ASSERT_TRUE(recording.ok());
  EXPECT_TRUE(absl::IsUnimplemented((*recording)->OpenScans(3, {}).status()));
  EXPECT_TRUE(absl::IsUnimplemented((*recording)->OpenScans(4, {}).status()));
  EXPECT_TRUE(absl::IsNotFound(OpenMessageRecording("/no/such.bag", {}).status()));
}

TEST(MessageFileTest, KindsAreToldByTheirFirstBytes) {
  for (const char* name : {"drive_none.bag", "drive_none.mcap", "drive.db3", "split_bag"}) {
    EXPECT_TRUE(IsMessageFile(DataFile(name))) << name;
  }
  for (const char* name : {"make_bags.py", "..", "no such file"}) {
    EXPECT_FALSE(IsMessageFile(DataFile(name))) << name;
  }
}

}  // namespace
}  // namespace isthmus::readers
