// isthmus changes: the built program, the real RPC layer, and behind it a pipeline that answers
// what the test says.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "core/io/file_io.h"
#include "tests/client/cli/program.h"
#include "tests/server/rpc/rpc_fixture.h"

namespace isthmus::cli {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

class ChangesTest : public rpc::RpcTest {
 protected:
  void SetUp() override {
    ChangedVolume cabinet;
    cabinet.T_map_box = Pose::FromXyzRpy(7.42, 3.1, 0.6, 0, 0, 0.5236);
    cabinet.size = {1.8, 0.5, 1.2};
    cabinet.points = 214;
    cabinet.probability = 0.958;
    cabinet.seen_first_ns = cabinet.seen_last_ns = 1'772'359'451'000'000'000;
    cabinet.missing_ns = 1'772'445'697'000'000'000;  // 2026-03-02 10:01:37 UTC.
    cabinet.seen_by = {RobotId("alice")};
    cabinet.missed_by = {RobotId("bob"), RobotId("carol")};
    cabinet.places = {{7, 3, 0.5}, {8, 3, 0.5}};
    ChangedVolume pallet = cabinet;
    pallet.came = true;
    pipeline_.changes = ChangeList{
        .revision = 97, .submaps_before = 14, .submaps_after = 15, .volumes = {cabinet, pallet}};
  }

  ProgramResult Ask(const std::string& options) const {
    return Isthmus("changes " + options + " --server " + server_->address());
  }
  std::string Path(const std::string& name) const { return folder_ + "/" + name; }

  const std::string folder_ = ScratchFolder();
};

TEST_F(ChangesTest, AreATable) {
  const ProgramResult table = Ask("--since 2026-03-02 --box 0,0,0,9,9,9 --smallest 0.5 --limit 7");
  ASSERT_EQ(table.code, 0) << table.err;
  EXPECT_EQ(pipeline_.asked_changes.since_ns, 1'772'409'600'000'000'000);
  EXPECT_EQ(pipeline_.asked_changes.smallest_m, 0.5);
  EXPECT_EQ(pipeline_.asked_changes.max_volumes, 7u);
  EXPECT_FALSE(pipeline_.asked_changes.wants_points);
  ASSERT_TRUE(pipeline_.asked_changes.box);
  EXPECT_EQ(pipeline_.asked_changes.box->max.x(), 9);
  EXPECT_THAT(table.out, HasSubstr("revision 97, 14 submaps before and 15 since: 1 volumes came, "
                                   "1 went\n"));
  EXPECT_THAT(table.out,
              HasSubstr("went      7.42     3.10     0.60     1.80   0.50   1.20    30     214  "
                        "0.958  2026-03-01 10:04:11  2026-03-02 10:01:37  alice; bob,carol\n"));
}

TEST_F(ChangesTest, AreJson) {
  const ProgramResult result = Ask("--since 12 --json");
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(pipeline_.asked_changes.since_revision, 12);
  const auto read = nlohmann::json::parse(result.out, nullptr, false);
  EXPECT_EQ(read["revision"], 97);
  EXPECT_EQ(read["submaps_after"], 15);
  ASSERT_EQ(read["volumes"].size(), 2u);
  EXPECT_EQ(read["volumes"][1]["kind"], "CAME");
  EXPECT_NEAR(read["volumes"][0]["yaw_deg"].get<double>(), 30, 0.01);
  EXPECT_EQ(read["volumes"][0]["box"]["size"]["y"], 0.5);
  EXPECT_EQ(read["volumes"][0]["missed_by"][1], "carol");
}

TEST_F(ChangesTest, AreFiles) {
  pipeline_.map->components_ = 1;
  for (int i = 0; i < 100; ++i) {
    pipeline_.map->points_.push_back({0.1f * static_cast<float>(i), 1, 1, 1, 0});
    pipeline_.map->points_.push_back({1, 0.1f * static_cast<float>(i), 2, 1, 0});
  }
  pipeline_.info.datum = Datum{.latitude_deg = 47, .longitude_deg = 8};
  const ProgramResult result = Ask("--since 12 --ply " + Path("c.ply") + " --geojson " +
                                   Path("c.geojson") + " --picture " + Path("c.png"));
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_TRUE(pipeline_.asked_changes.wants_points);
  const std::string ply = *io::ReadFile(Path("c.ply"));
  EXPECT_THAT(ply, HasSubstr("element vertex 4\n"));
  const std::string header_end = "end_header\n";
  // Three floats, three bytes and a number for each point.
  EXPECT_EQ(ply.size() - ply.find(header_end) - header_end.size(), 4u * 19);
  EXPECT_THAT(*io::ReadFile(Path("c.png")), StartsWith("\x89PNG"));
  const auto json = nlohmann::json::parse(*io::ReadFile(Path("c.geojson")), nullptr, false);
  ASSERT_EQ(json["features"].size(), 2u);
  EXPECT_EQ(json["features"][0]["properties"]["kind"], "went");
  EXPECT_EQ(json["features"][0]["properties"]["missing"], "2026-03-02T10:01:37.000Z");
  const auto& ring = json["features"][0]["geometry"]["coordinates"][0];
  ASSERT_EQ(ring.size(), 5u);
  EXPECT_EQ(ring[0], ring[4]);
  EXPECT_NEAR(ring[0][0].get<double>(), 8, 1e-3);
  EXPECT_NEAR(ring[0][1].get<double>(), 47, 1e-3);
}

TEST_F(ChangesTest, ExitCodesSayWhatIsWrong) {
  EXPECT_EQ(Ask("").code, 2);
  const ProgramResult unclear = Ask("--since yesterday");
  EXPECT_EQ(unclear.code, 2);
  EXPECT_THAT(unclear.err, HasSubstr("the number of a revision"));
  EXPECT_EQ(Ask("--since 3 --box 1,2").code, 2);
  EXPECT_EQ(Ask("--since 3 --ply /no/such/folder/c.ply").code, 5);
  const ProgramResult nowhere = Ask("--since 3 --geojson " + Path("c.geojson"));
  EXPECT_EQ(nowhere.code, 3);
  EXPECT_THAT(nowhere.err, HasSubstr("isthmus datum set"));
  EXPECT_FALSE(std::filesystem::exists(Path("c.geojson")));
  pipeline_.changes = absl::OutOfRangeError("the oldest that is kept is 7");
  EXPECT_EQ(Ask("--since 3").code, 6);
  pipeline_.changes = absl::FailedPreconditionError("nothing is from before that");
  EXPECT_EQ(Ask("--since 3").code, 3);
}

}  // namespace
}  // namespace isthmus::cli
