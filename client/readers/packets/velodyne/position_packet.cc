#include "client/readers/packets/velodyne/position_packet.h"

#include <absl/strings/numbers.h>
#include <absl/strings/str_split.h>

#include <chrono>
#include <cmath>
#include <vector>

#include "core/codec/column.h"

namespace isthmus::readers::velodyne {
namespace {

constexpr size_t kClockAt = 198;     // Format
constexpr size_t kSentenceAt = 206;  // Format

// The number in two digits of the text.
std::optional<int> TwoDigits(absl::string_view text, size_t at) {
  int value = 0;
  if (text.size() < at + 2 || !absl::SimpleAtoi(text.substr(at, 2), &value) || value < 0) {
    return std::nullopt;
  }
  return value;
}

// hhmmss.ss of ddmmyy; the year is of this century.
std::optional<int64_t> UtcOf(absl::string_view time, absl::string_view date) {
  const std::optional<int> hour = TwoDigits(time, 0), minute = TwoDigits(time, 2),
                           day = TwoDigits(date, 0), month = TwoDigits(date, 2),
                           year = TwoDigits(date, 4);
  double seconds = 0;
  if (!hour || !minute || !day || !month || !year || time.size() < 6 ||
      !absl::SimpleAtod(time.substr(4), &seconds) || !(seconds >= 0 && seconds < 61)) {
    return std::nullopt;
  }
  const std::chrono::year_month_day calendar{std::chrono::year(2000 + *year),
                                             std::chrono::month(static_cast<unsigned>(*month)),
                                             std::chrono::day(static_cast<unsigned>(*day))};
  if (!calendar.ok() || *hour > 23 || *minute > 59) return std::nullopt;
  const auto days = std::chrono::sys_days(calendar).time_since_epoch();
  const int64_t whole = days.count() * int64_t{86400} + *hour * 3600 + *minute * 60;
  return whole * 1'000'000'000 + std::llround(seconds * 1e9);
}

// ddmm.mmmm or dddmm.mmmm, and a letter.
std::optional<double> DegreesOf(absl::string_view text, size_t digits, absl::string_view letter,
                                const char* letters, double limit) {
  int degrees = 0;
  double minutes = 0;
  if (text.size() < digits + 2 || letter.size() != 1 ||
      !absl::SimpleAtoi(text.substr(0, digits), &degrees) || degrees < 0 ||
      !absl::SimpleAtod(text.substr(digits), &minutes) || !(minutes >= 0 && minutes < 60)) {
    return std::nullopt;
  }
  const double value = degrees + minutes / 60;
  if (value > limit || (letter[0] != letters[0] && letter[0] != letters[1])) return std::nullopt;
  return letter[0] == letters[1] ? -value : value;
}

// XOR of what is between $ and *, in hexadecimal digits; fine where there is none.
bool ChecksumFits(absl::string_view sentence) {
  const size_t star = sentence.find('*');
  if (star == absl::string_view::npos) return true;
  uint8_t sum = 0;
  for (const char c : sentence.substr(1, star - 1)) sum ^= static_cast<uint8_t>(c);
  uint32_t given = 0;
  return absl::SimpleHexAtoi(sentence.substr(star + 1, 2), &given) && given == sum;
}

}  // namespace

std::optional<PositionPacket> ParsePositionPacket(absl::string_view bytes) {
  if (bytes.size() != kPositionPacketBytes) return std::nullopt;
  PositionPacket packet;
  packet.microseconds = codec::LoadAs<uint32_t>(bytes.data() + kClockAt);
  packet.sentence = bytes.substr(kSentenceAt);
  packet.sentence =
      packet.sentence.substr(0, packet.sentence.find_first_of(absl::string_view("\r\n\0", 3)));
  const bool rmc = packet.sentence.size() > 7 && packet.sentence.substr(0, 2) == "$G" &&
                   packet.sentence.substr(3, 4) == "RMC,";
  return rmc ? std::optional(packet) : std::nullopt;
}

std::optional<GprmcFix> ParseGprmc(absl::string_view sentence) {
  if (sentence.empty() || sentence[0] != '$' || !ChecksumFits(sentence)) return std::nullopt;
  const std::vector<absl::string_view> fields =
      absl::StrSplit(sentence.substr(0, sentence.find('*')), ',');
  if (fields.size() < 10 || fields[0].size() != 6 || fields[0].substr(3) != "RMC" ||
      fields[2] != "A") {
    return std::nullopt;
  }
  const std::optional<int64_t> stamp_ns = UtcOf(fields[1], fields[9]);
  const std::optional<double> latitude = DegreesOf(fields[3], 2, fields[4], "NS", 90);
  const std::optional<double> longitude = DegreesOf(fields[5], 3, fields[6], "EW", 180);
  if (!stamp_ns || !latitude || !longitude) return std::nullopt;
  return GprmcFix{*stamp_ns, *latitude, *longitude};
}

}  // namespace isthmus::readers::velodyne
