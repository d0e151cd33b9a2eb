// A capture with fixes, pushed to a real server over a socket.
#include <absl/strings/str_format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numbers>

#include "client/offline/embedded_server.h"
#include "tests/client/cli/program.h"
#include "tests/client/readers/packets/packet_writer.h"

namespace isthmus::cli {
namespace {

using nlohmann::json;
using readers::testing::CaptureWriter;
using readers::testing::VelodyneSource;
using testing::HasSubstr;

constexpr int64_t kCaptureStartNs = 1'699'999'200'000'000'000;  // 2023-11-14 22:00:00 UTC.
constexpr char kTopic[] = "udp 8308 from 192.168.1.201";

// The measurements of a VLP-16 in the middle of a room of 20 by 16 by 6 m, in its 2 mm.
VelodyneSource RoomFrom(int packet) {
  VelodyneSource source;
  source.range = [packet, step = source.step](int block, int laser, int) {
    const int firing = laser / 16, ring = laser % 16;
    // By the sensor's manual: even lasers look down, odd ones up, 2 degrees apart.
    const double up = (ring % 2 == 0 ? -15.0 + ring : ring) * std::numbers::pi / 180;
    const double turn = (packet * 12 + block + 0.5 * firing) * step * 0.01 * std::numbers::pi / 180;
    const double x = std::cos(up) * std::sin(turn), y = std::cos(up) * std::cos(turn);
    const double wall = std::min(10 / std::max(std::abs(x), 1e-9), 8 / std::max(std::abs(y), 1e-9));
    const double range = std::min(wall, 3 / std::max(std::abs(std::sin(up)), 1e-9));
    return static_cast<uint16_t>(range / 0.002);
  };
  return source;
}

// Two seconds of a sensor that stands still, and a fix in each.
std::string WriteDrive(const std::string& name) {
  CaptureWriter writer(readers::testing::Link::kEthernet);
  for (int i = 0; i < 1600; ++i) {
    const VelodyneSource source = RoomFrom(i);
    const int64_t since_ns = VelodyneTimeNs(source, i);
    const int64_t arrival_ns = kCaptureStartNs + since_ns;
    writer.Add({}, VelodynePacketOf(source, i, 0), arrival_ns);
    if (i % 100 != 0) continue;
    const std::string sentence =
        absl::StrFormat("GPRMC,22000%d.00,A,4807.038,N,01131.000,E,000.0,000.0,141123,003.1,W",
                        since_ns / 1'000'000'000);
    writer.Add({"192.168.1.201", 8308},
               readers::testing::PositionPacketOf(static_cast<uint32_t>(since_ns / 1000), sentence),
               arrival_ns);
  }
  return readers::testing::WriteTestFile(name, writer.bytes());
}

struct GnssTest : testing::Test {
  void SetUp() override {
    server::PipelineOptions options;
    options.composition_interval_s = 0;
    auto started = EmbeddedServer::Start(options);
    ASSERT_TRUE(started.ok()) << started.status();
    server = *std::move(started);
  }
  ProgramResult Ask(const std::string& command) const {
    return Isthmus(command + " --server " + server->client().address());
  }
  std::unique_ptr<EmbeddedServer> server;
  const std::string drive = WriteDrive("drive.pcap");
};

TEST_F(GnssTest, InfoNamesTheTopicAsAShellTakesIt) {
  EXPECT_THAT(Isthmus("info " + drive).out,
              HasSubstr(std::string("--gnss '") + kTopic + "' anchors"));
}

TEST_F(GnssTest, TheFirstFixBecomesTheDatumAndSubmapsAreAnchored) {
  const ProgramResult pushed =
      Ask("push " + drive + " --robot alice --json --gnss '" + kTopic + "'");
  ASSERT_EQ(pushed.code, 0) << pushed.err;
  json summary = json::parse(pushed.out);
  EXPECT_GE(summary["processed"], 15) << pushed.out;
  EXPECT_EQ(summary["gnss"]["anchored"], 1);
  EXPECT_EQ(summary["gnss"]["submaps"], 1);
  EXPECT_EQ(summary["gnss"]["sets_datum"], true);
  EXPECT_THAT(pushed.err, HasSubstr("no static transform gives the place of the antenna"));
  json datum = json::parse(Ask("datum show --json").out)["datum"];
  SCOPED_TRACE(datum.dump());
  EXPECT_NEAR(datum["latitude_deg"].get<double>(), 48 + 7.038 / 60, 1e-9);
  EXPECT_NEAR(datum["longitude_deg"].get<double>(), 11 + 31.0 / 60, 1e-9);
  const json anchors = json::parse(Ask("anchor list --json").out);
  ASSERT_FALSE(anchors.empty());
  EXPECT_THAT(anchors.dump(), HasSubstr("GNSS"));
}

TEST_F(GnssTest, ATopicThatIsNotThereIsRefusedBeforeAnythingIsPushed) {
  const ProgramResult pushed = Ask("push " + drive + " --robot alice --gnss /fix");
  EXPECT_NE(pushed.code, 0);
  EXPECT_THAT(pushed.err, HasSubstr(kTopic)) << "names what there is";
  EXPECT_THAT(Ask("robots --json").out, testing::Not(HasSubstr("alice")));
  const ProgramResult other = Ask("push " + drive + " --robot alice --gnss '" + kTopic + "=bob'");
  EXPECT_THAT(other.err, HasSubstr("bob, which is not pushed"));
}

}  // namespace
}  // namespace isthmus::cli
