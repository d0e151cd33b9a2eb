#include "core/map/map_name.h"

#include <gtest/gtest.h>

#include "core/records/map_info.h"

namespace isthmus {
namespace {

MapInfo TwoMaps() {
  MapInfo info;
  info.components.resize(2);
  info.components[0].sessions = {SessionId("bob-1"), SessionId("bob-2")};
  info.components[1].component = 1;
  info.components[1].sessions = {SessionId("alice-1")};
  return info;
}

TEST(MapName, IsANumberOrASession) {
  EXPECT_EQ(MapName::FromText("7"), MapName(7));
  EXPECT_EQ(MapName::FromText("alice-1"), MapName(SessionId("alice-1")));
  EXPECT_EQ(MapName::FromText("7-1"), MapName(SessionId("7-1"))) << "of a robot called 7";
  EXPECT_EQ(MapName::FromText("99999999999"), MapName(SessionId("99999999999"))) << "none has it";
  for (const char* text : {"0", "12", "alice-1"}) EXPECT_EQ(MapName::FromText(text).ToText(), text);
}

TEST(MapName, MeansTheMapThatTheSessionIsIn) {
  const MapInfo info = TwoMaps();
  EXPECT_EQ(*NumberIn(info, 1), 1u);
  EXPECT_EQ(*NumberIn(info, MapName(SessionId("alice-1"))), 1u);
  EXPECT_EQ(*NumberIn(info, MapName(SessionId("bob-2"))), 0u);
  EXPECT_EQ(*NumberIn(MapInfo(), {}), 0u) << "an empty map may be asked for";
}

TEST(MapName, SaysWhatToDoWhereThereIsNone) {
  const MapInfo info = TwoMaps();
  const absl::Status number = NumberIn(info, 2).status();
  EXPECT_TRUE(absl::IsNotFound(number)) << number;
  EXPECT_NE(number.message().find("there are 2"), std::string::npos) << number;
  const absl::Status deleted = NumberIn(info, MapName(SessionId("carol-1"))).status();
  EXPECT_TRUE(absl::IsNotFound(deleted)) << deleted;
  EXPECT_NE(deleted.message().find("Any session in a map names it"), std::string::npos) << deleted;
}

TEST(MapName, RobotOfAnotherMapIsToldItsName) {
  const MapInfo info = TwoMaps();
  const auto number_of = [&info](const SessionId& session) -> std::optional<uint32_t> {
    const auto number = NumberIn(info, MapName(session));
    if (!number.ok()) return std::nullopt;
    return *number;
  };
  const RobotId bob("bob");
  const SessionId one("bob-1"), unplaced("bob-3");
  EXPECT_TRUE(CheckRobotIsIn(0, bob, {unplaced, one}, number_of).ok());
  EXPECT_TRUE(CheckRobotIsIn(1, bob, {unplaced}, number_of).ok()) << "in none yet";
  const absl::Status elsewhere = CheckRobotIsIn(1, bob, {one, unplaced}, number_of);
  EXPECT_TRUE(absl::IsFailedPrecondition(elsewhere)) << elsewhere;
  EXPECT_NE(elsewhere.message().find("ask for the map bob-1"), std::string::npos) << elsewhere;
}

}  // namespace
}  // namespace isthmus
