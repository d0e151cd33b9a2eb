#include "client/readers/packets/velodyne/position_packet.h"

#include <gtest/gtest.h>

#include <string>

#include "tests/client/readers/packets/packet_writer.h"

namespace isthmus::readers::velodyne {
namespace {

constexpr char kValid[] = "GPRMC,081802.25,A,3649.7478558,N,00224.4542928,W,0.03,212.5,210116,,,A";

TEST(PositionPacket, GivesTheClockAndTheSentence) {
  const std::string bytes = testing::PositionPacketOf(1'082'340'595, kValid);
  const auto packet = ParsePositionPacket(bytes);
  ASSERT_TRUE(packet);
  EXPECT_EQ(packet->microseconds, 1'082'340'595u);
  const auto fix = ParseGprmc(packet->sentence);
  ASSERT_TRUE(fix);
  EXPECT_EQ(fix->stamp_ns, 1'453'364'282'250'000'000);  // 2016-01-21 08:18:02.25
  EXPECT_NEAR(fix->latitude_deg, 36 + 49.7478558 / 60, 1e-12);
  EXPECT_NEAR(fix->longitude_deg, -(2 + 24.4542928 / 60), 1e-12);
}

TEST(PositionPacket, RefusesEverythingElse) {
  const std::string bytes = testing::PositionPacketOf(0, kValid);
  EXPECT_FALSE(ParsePositionPacket(bytes.substr(1)));
  EXPECT_FALSE(ParsePositionPacket(std::string(512, '\0')));
  EXPECT_FALSE(ParsePositionPacket(""));
  for (const char* sentence :
       {"", "$", "$GPRMC", "$GPRMC,,,,,,,,,,", "$GPGGA,081802.00,A,3649.7,N,00224.4,W,0,0,210116",
        "$GPRMC,081802.00,V,3649.7,N,00224.4,W,0,0,210116",
        "$GPRMC,251802.00,A,3649.7,N,00224.4,W,0,0,210116",
        "$GPRMC,081802.00,A,3649.7,N,00224.4,W,0,0,310216",
        "$GPRMC,081802.00,A,9949.7,N,00224.4,W,0,0,210116",
        "$GPRMC,081802.00,A,3649.7,X,00224.4,W,0,0,210116",
        "$GPRMC,081802.00,A,3669.7,N,00224.4,W,0,0,210116",
        "$GPRMC,0818nan,A,3649.7,N,00224.4,W,0,0,210116",
        "$GPRMC,081802.00,A,3649.7,N,00224.4,W,0,0,210116*00",
        "$GPRMC,081802.00,A,3649.7,N,00224.4,W,0,0,210116*"}) {
    EXPECT_FALSE(ParseGprmc(sentence)) << sentence;
  }
  EXPECT_TRUE(ParseGprmc("$GNRMC,081802.00,A,3649.7,S,00224.4,E,0,0,210116"));
}

}  // namespace
}  // namespace isthmus::readers::velodyne
