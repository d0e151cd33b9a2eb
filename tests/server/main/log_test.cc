// Lines of the log: whatever they quote, each is one line, for eyes or for programs.
#include "server/main/log.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

namespace isthmus::server {
namespace {

constexpr int64_t kTime = 1'772'359'438'250'000'000;  // 2026-03-01T10:03:58.250Z
const std::string kHostile = "x\n2026-03-01 info forged\x1b[31m \xff \"quoted\"";

LogFields All() {
  LogFields fields;
  fields.site = "yard";
  fields.robot = "alice";
  fields.session = "alice-1";
  fields.sequence = 7;
  fields.event = "ROBOT_LOST";
  fields.rpc = "GetSession";
  fields.code = "NOT_FOUND";
  fields.request_id = "12";
  fields.peer = "ipv4:10.0.0.7:1";
  fields.token = "chief";
  return fields;
}

TEST(LogTest, ALineOfJsonHoldsWhatIsKnown) {
  const std::string line = FormatLine(true, spdlog::level::warn, kTime, kHostile, All());
  EXPECT_EQ(std::count(line.begin(), line.end(), '\n'), 1);
  EXPECT_EQ(line.back(), '\n');
  const auto parsed = nlohmann::json::parse(line);
  EXPECT_EQ(parsed["time"], "2026-03-01T10:03:58.250Z");
  EXPECT_EQ(parsed["level"], "warning");
  EXPECT_THAT(parsed["message"].get<std::string>(), testing::HasSubstr("\"quoted\""));
  EXPECT_EQ(parsed["site"], "yard");
  EXPECT_EQ(parsed["robot"], "alice");
  EXPECT_EQ(parsed["session"], "alice-1");
  EXPECT_EQ(parsed["sequence"], 7);
  EXPECT_EQ(parsed["event"], "ROBOT_LOST");
  EXPECT_EQ(parsed["rpc"], "GetSession");
  EXPECT_EQ(parsed["code"], "NOT_FOUND");
  EXPECT_EQ(parsed["request_id"], "12");
  EXPECT_EQ(parsed["peer"], "ipv4:10.0.0.7:1");
  EXPECT_EQ(parsed["token"], "chief");
  EXPECT_EQ(nlohmann::json::parse(FormatLine(true, spdlog::level::info, kTime, "x", {})).size(),
            3u);
}

TEST(LogTest, ALineOfTextIsOneLineAndNamesTheCaller) {
  LogFields fields = All();
  fields.token = "a\nb";
  const std::string line = FormatLine(false, spdlog::level::info, kTime, kHostile, fields);
  EXPECT_EQ(std::count(line.begin(), line.end(), '\n'), 1);
  EXPECT_THAT(line, testing::HasSubstr(" info yard: x\\x0a2026"));
  EXPECT_THAT(line, testing::HasSubstr(" (request 12, peer ipv4:10.0.0.7:1, token a\\x0ab)\n"));
  EXPECT_THAT(line, testing::Not(testing::HasSubstr("\x1b")));
  fields = {};
  fields.site = "default";
  EXPECT_THAT(FormatLine(false, spdlog::level::info, kTime, "ready", fields),
              testing::EndsWith(" info ready\n"));
}

}  // namespace
}  // namespace isthmus::server
