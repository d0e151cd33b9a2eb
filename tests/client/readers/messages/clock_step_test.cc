// Recordings whose recorder's clock was set back.
#include "client/readers/messages/clock_step.h"

#include <gmock/gmock.h>
#include <sqlite3.h>

#include <algorithm>
#include <filesystem>
#include <limits>

#include "core/byte_stream.h"
#include "tests/client/readers/messages/damage_helpers.h"

namespace isthmus::readers {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr int64_t kSecond = 1'000'000'000;
constexpr int64_t kStart = 1'700'000'000 * kSecond;

// `count` times, 0.1 s apart.
std::vector<int64_t> Tenths(double start_s, int count) {
  std::vector<int64_t> times;
  for (int i = 0; i < count; ++i) {
    times.push_back(kStart + static_cast<int64_t>(start_s * 1e9) + i * kSecond / 10);
  }
  return times;
}

std::vector<int64_t> InTurn(std::vector<int64_t> first, const std::vector<int64_t>& second) {
  first.insert(first.end(), second.begin(), second.end());
  return first;
}

// In stretches of so many.
std::optional<ClockStep> FindIn(const std::vector<int64_t>& times, size_t stretch = 1) {
  std::vector<LogSpan> spans;
  for (size_t i = 0; i < times.size(); i += stretch) {
    const auto begin = times.begin() + static_cast<std::ptrdiff_t>(i);
    const auto end =
        times.begin() + static_cast<std::ptrdiff_t>(std::min(i + stretch, times.size()));
    spans.push_back({*std::min_element(begin, end), *std::max_element(begin, end)});
  }
  return FindClockStep(spans);
}

TEST(ClockStep, IsWhereTimesGoBackOnce) {
  for (const double back_s : {2.5, 5.0, 19.0, 3600.0, 1.6e9}) {
    const std::vector<int64_t> times = InTurn(Tenths(0, 200), Tenths(20 - back_s, 200));
    for (const size_t stretch : {1, 4, 7}) {
      const auto step = FindIn(times, stretch);
      ASSERT_TRUE(step) << back_s << " " << stretch;
      EXPECT_TRUE(step->was_set);
      EXPECT_EQ(step->at, 200 / stretch);
      EXPECT_EQ(step->is_within, stretch == 7);
      EXPECT_NEAR(step->back_s, back_s, 0.2);
      EXPECT_THAT(step->Text(), HasSubstr("in the order of the file"));
    }
  }
}

TEST(ClockStep, PartsInTheWrongOrderAreToldFromIt) {
  for (const size_t stretch : {1, 7}) {
    const auto step = FindIn(InTurn(Tenths(20, 200), Tenths(0, 200)), stretch);
    ASSERT_TRUE(step);
    EXPECT_FALSE(step->was_set);
    EXPECT_THAT(step->Text(), HasSubstr("come by these times"));
  }
}

TEST(ClockStep, OtherOrdersHaveNone) {
  std::vector<int64_t> times = Tenths(0, 100);
  EXPECT_FALSE(FindIn({}));
  EXPECT_FALSE(FindIn({kStart}));
  EXPECT_FALSE(FindIn(times));
  EXPECT_FALSE(FindIn(InTurn(times, times)));
  EXPECT_FALSE(FindIn(InTurn(times, {kStart - 50 * kSecond})));             // An odd one.
  std::rotate(times.begin() + 50, times.begin() + 54, times.begin() + 55);  // One is late.
  EXPECT_FALSE(FindIn(times));
  std::reverse(times.begin(), times.end());
  EXPECT_FALSE(FindIn(times));
  const int64_t most = std::numeric_limits<int64_t>::max();
  EXPECT_FALSE(FindIn({most, -most, most, -most}));
}

std::string Sized(const std::string& text) {
  std::string bytes;
  AppendBytes(static_cast<uint32_t>(text.size()), bytes);
  return bytes + text;
}

std::string McapRecord(char op, const std::string& content) {
  std::string bytes(1, op);
  AppendBytes(static_cast<uint64_t>(content.size()), bytes);
  return bytes + content;
}

// An MCAP without a summary, of messages with these times, in chunks of so many; 0: outside of
// chunks.
std::string McapOf(const std::vector<int64_t>& times, size_t chunk) {
  // Messages outside of chunks are read by the megabyte.
  const std::string words(chunk == 0 ? 50'000 : 5, 'w');
  const std::string magic("\x89MCAP0\r\n", 8), id("\x01\0", 2), none("\0\0\0\0", 4);
  std::string file = magic + McapRecord(1, Sized("") + Sized(""));
  file += McapRecord(3, id + Sized("std_msgs/msg/String") + Sized("ros2msg") + Sized(""));
  file += McapRecord(4, id + id + Sized("/words") + Sized("cdr") + none);
  for (size_t i = 0; i < times.size(); i += std::max<size_t>(chunk, 1)) {
    std::string records;
    const size_t end = std::min(i + std::max<size_t>(chunk, 1), times.size());
    for (size_t k = i; k < end; ++k) {
      std::string message = id + none;
      AppendBytes(times[k], message);
      AppendBytes(times[k], message);
      records += McapRecord(5, message + words);
    }
    if (chunk == 0) {
      file += records;
      continue;
    }
    std::string head;
    AppendBytes(*std::min_element(&times[i], &times[i] + (end - i)), head);
    AppendBytes(*std::max_element(&times[i], &times[i] + (end - i)), head);
    AppendBytes(static_cast<uint64_t>(records.size()), head);
    head += none + Sized("");
    AppendBytes(static_cast<uint64_t>(records.size()), head);
    file += McapRecord(6, head + records);
  }
  return file + McapRecord(15, none) + McapRecord(2, std::string(20, '\0')) + magic;
}

struct TimesGiven {
  std::vector<int64_t> times;
  std::vector<std::string> assumptions;
};

TimesGiven ReadLogTimes(const std::shared_ptr<const MessageFile>& file) {
  TimesGiven given;
  const auto reader = file->OpenReader({0});
  EXPECT_TRUE(reader.ok()) << reader.status();
  while (reader.ok()) {
    const auto message = (*reader)->Next();
    EXPECT_TRUE(message.ok()) << message.status();
    if (!message.ok() || !message->has_value()) break;
    given.times.push_back((*message)->log_ns);
  }
  if (reader.ok()) given.assumptions = (*reader)->Assumptions();
  return given;
}

TEST(ClockStep, MessagesOfAClockThatWasSetComeInTheOrderOfTheFile) {
  for (const double back_s : {3.0, 3600.0}) {
    const std::vector<int64_t> times = InTurn(Tenths(0, 60), Tenths(6 - back_s, 50));
    for (const size_t chunk : {0, 1, 7, 1000}) {
      const auto file = OpenMessageBytes(BufferSource(McapOf(times, chunk)), "drive");
      ASSERT_TRUE(file.ok()) << file.status();
      const TimesGiven given = ReadLogTimes(*file);
      EXPECT_EQ(given.times, times) << chunk;
      EXPECT_THAT(given.assumptions, testing::ElementsAre(HasSubstr("clock was probably set")));
    }
  }
}

TEST(ClockStep, MessagesInTheWrongOrderComeByTheirTimes) {
  const std::vector<int64_t> sorted = Tenths(0, 110);
  std::vector<int64_t> parts = sorted, swapped = sorted;
  std::rotate(parts.begin(), parts.begin() + 50, parts.end());
  for (size_t i = 0; i + 1 < swapped.size(); i += 2) std::swap(swapped[i], swapped[i + 1]);
  for (const size_t chunk : {0, 1, 7, 1000}) {
    const auto file = OpenMessageBytes(BufferSource(McapOf(parts, chunk)), "drive");
    ASSERT_TRUE(file.ok()) << file.status();
    EXPECT_EQ(ReadLogTimes(*file).times, sorted) << chunk;
    EXPECT_THAT(ReadLogTimes(*file).assumptions, testing::ElementsAre(HasSubstr("wrong order")));
    const auto other = OpenMessageBytes(BufferSource(McapOf(swapped, chunk)), "drive");
    ASSERT_TRUE(other.ok()) << other.status();
    EXPECT_EQ(ReadLogTimes(*other).times, sorted) << chunk;
    EXPECT_THAT(ReadLogTimes(*other).assumptions, IsEmpty());
  }
}

TEST(ClockStep, IsFoundInDatabases) {
  const fs::path path = fs::path(testing::TempDir()) / "isthmus_clock_step.db3";
  fs::copy_file(DataFile("drive.db3"), path, fs::copy_options::overwrite_existing);
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(path.c_str(), &database), SQLITE_OK);
  const char* sql =
      "UPDATE messages SET timestamp = 1700000000000000000 + 500000000 * id"
      " - CASE WHEN id > 10 THEN 4000000000 ELSE 0 END";
  EXPECT_EQ(sqlite3_exec(database, sql, nullptr, nullptr, nullptr), SQLITE_OK);
  sqlite3_close(database);
  const auto file = OpenMessageFile(path);
  ASSERT_TRUE(file.ok()) << file.status();
  const AllMessages all = ReadMessages(*file);
  ASSERT_EQ(all.messages.size(), 20u);
  for (size_t i = 0; i < 20; ++i) {
    const int64_t time =
        kStart + static_cast<int64_t>(i + 1) * kSecond / 2 - (i < 10 ? 0 : 4 * kSecond);
    EXPECT_THAT(all.messages[i], HasSubstr(" " + std::to_string(time) + " "));
  }
  fs::remove(path);
}

}  // namespace
}  // namespace isthmus::readers
