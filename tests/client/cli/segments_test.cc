// A drive that breaks off in one place and goes on in another: the commands tell of it, and no file
// of poses mixes frames.
#include <absl/strings/str_format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "client/offline/embedded_server.h"
#include "core/formats/tum.h"
#include "tests/client/cli/program.h"

namespace isthmus::cli {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::HasSubstr;
using testing::Not;

// Scans of the museum, and then of a campus that the session knows nothing of.
constexpr int kMuseum = 25, kCampus = 45;

class SegmentsTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new std::string(ScratchFolder());
    fs::create_directories(Path("kidnapped"));
    int scan = 0;
    for (const auto& [world, scans] :
         {std::pair("museum", kMuseum), std::pair("campus", kCampus)}) {
      ASSERT_EQ(Isthmus(absl::StrFormat("simulate --world %s --robots 1 --seconds %.1f -o %s",
                                        world, 0.1 * scans, Path(world)))
                    .code,
                0);
      for (int i = 0; i < scans; ++i) {
        fs::rename(Path(absl::StrFormat("%s/robot_0/%06d.pcd", world, i)),
                   Path(absl::StrFormat("kidnapped/%06d.pcd", scan++)));
      }
    }
  }
  static void TearDownTestSuite() {
    fs::remove_all(*folder_);
    delete folder_;
  }
  static std::string Path(const std::string& name) { return *folder_ + "/" + name; }

  static std::string* folder_;
};

std::string* SegmentsTest::folder_ = nullptr;

size_t PosesIn(const std::string& file) {
  const auto poses = formats::ReadTum(file);
  return poses.ok() ? poses->size() : 0;
}

TEST_F(SegmentsTest, OdometryWritesAFileForEachAndDoesNotLookLikeSuccess) {
  const ProgramResult result = Isthmus("odometry --sensor vlp16 " + Path("kidnapped") + " -o " +
                                       Path("poses.tum") + " --json");
  EXPECT_EQ(result.code, 7) << result.err;
  EXPECT_THAT(result.err, HasSubstr("2 segments; poses of different segments share no frame"));
  const json summary = json::parse(result.out);
  ASSERT_EQ(summary["segments"].size(), 2u);
  EXPECT_EQ(PosesIn(Path("poses.tum")), 0u + kMuseum);
  EXPECT_EQ(PosesIn(Path("poses.2.tum")), summary["segments"][1]["poses"]);
  const int lost = summary["lost"];
  EXPECT_GT(lost, (kMuseum + kCampus) / 10);
  EXPECT_EQ(summary["poses"], kMuseum + kCampus - lost);
  EXPECT_EQ(summary["scans"]["lost"], lost);
  EXPECT_THAT(result.err,
              HasSubstr(absl::StrFormat("lost in %d of %d scans", lost, kMuseum + kCampus)));
}

TEST_F(SegmentsTest, OdometryOfAGoodDriveIsASuccess) {
  std::ofstream(Path("good.2.tum")) << "of an earlier drive\n";
  const ProgramResult result =
      Isthmus(absl::StrFormat("odometry --sensor vlp16 --to %d %s -o %s", kMuseum - 1,
                              Path("kidnapped"), Path("good.tum")));
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("25 ok, 0 degenerate, 0 lost, 0 rejected"));
  EXPECT_FALSE(std::filesystem::exists(Path("good.2.tum")));
  EXPECT_THAT(result.err, Not(HasSubstr("lost")));
}

TEST_F(SegmentsTest, APushSaysSoAndTheServerTellsThemApart) {
  const auto server = EmbeddedServer::Start({});
  ASSERT_TRUE(server.ok()) << server.status();
  const auto ask = [&](const std::string& command) {
    return Isthmus(command + " --server " + (*server)->client().address());
  };
  const ProgramResult push = ask("push --robot alice --sensor vlp16 " + Path("kidnapped"));
  EXPECT_EQ(push.code, 0) << push.err;
  EXPECT_THAT(push.err, HasSubstr("in segment 2 (alice-1.2)"));
  EXPECT_THAT(push.out, HasSubstr("2 segments; poses of different segments share no frame"));
  ASSERT_EQ(ask("status --wait settled --timeout 100").code, 0);
  EXPECT_THAT(ask("status").out, HasSubstr("; segment 2 of 2"));
  EXPECT_EQ(json::parse(ask("status --json").out)["tracking"]["alice"]["segments"], 2);
  EXPECT_THAT(ask("robots").out, HasSubstr("segment 2 of alice-1"));
  EXPECT_THAT(ask("graph").out, HasSubstr("alice-1.2"));

  const ProgramResult odom = ask("trajectory alice --frame odom -o " + Path("last.tum"));
  EXPECT_EQ(odom.code, 0);
  EXPECT_THAT(odom.out, HasSubstr("segment 2; not in it (another frame; see --segment): 1"));
  EXPECT_EQ(ask("trajectory alice --frame odom --segment 1 -o " + Path("first.tum")).code, 0);
  EXPECT_EQ(PosesIn(Path("first.tum")), 0u + kMuseum);
  EXPECT_EQ(ask("trajectory alice --frame odom --segment 3 -o " + Path("none.tum")).code, 6);
  // A museum and a campus are not one place: they lie in two maps.
  const ProgramResult map = ask("trajectory alice -o " + Path("map.tum"));
  EXPECT_THAT(map.out, HasSubstr("another map, or not placed"));
  EXPECT_EQ(ask("trajectory alice --segment 2 -o " + Path("map2.tum")).code, 0);
  EXPECT_EQ(PosesIn(Path("map2.tum")), PosesIn(Path("last.tum")));
}

}  // namespace
}  // namespace isthmus::cli
