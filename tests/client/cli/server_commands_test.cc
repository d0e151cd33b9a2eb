// The commands that speak to a server, against a real one over a socket.
#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "client/offline/embedded_server.h"
#include "core/codec/payload_builder.h"
#include "core/formats/pcd.h"
#include "core/formats/tum.h"
#include "tests/client/cli/program.h"

namespace isthmus::cli {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::HasSubstr;

// One server and one small recording for all tests; robots have names of their own.
class ServerCommandsTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new std::string(ScratchFolder());
    const ProgramResult simulated = Isthmus(
        "simulate --world museum --robots 2 --seconds 3 --seed 1 -o " + *folder_ + " --json");
    ASSERT_EQ(simulated.code, 0) << simulated.err;
    ASSERT_EQ(json::parse(simulated.out)["scans_per_robot"], 30);
    server::PipelineOptions options;
    options.composition_interval_s = 0;
    auto server = EmbeddedServer::Start(options);
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = server->release();
  }
  static void TearDownTestSuite() {
    delete server_;
    fs::remove_all(*folder_);
    delete folder_;
  }

  static std::string Path(const std::string& name) { return *folder_ + "/" + name; }

  ProgramResult Ask(const std::string& command) const {
    return Isthmus(command + " --server " + server_->client().address());
  }
  json AskJson(const std::string& command) const {
    const ProgramResult result = Ask(command + " --json");
    EXPECT_EQ(result.code, 0) << result.err;
    json document = json::parse(result.out, nullptr, false);
    EXPECT_EQ(document.value("version", 0), 2) << command << ": " << result.out;
    return document;
  }
  // By value: a loop over a part of a document does not keep the document.
  json Sessions(const std::string& command) const { return AskJson(command)["sessions"]; }

  static EmbeddedServer* server_;
  static std::string* folder_;
};

EmbeddedServer* ServerCommandsTest::server_ = nullptr;
std::string* ServerCommandsTest::folder_ = nullptr;

TEST_F(ServerCommandsTest, PushReportsEveryScanAndFinishesTheSession) {
  const json summary = AskJson("push --robot pushed --resolution 0.002 " + Path("robot_0"));
  EXPECT_EQ(summary["processed"], 30);
  EXPECT_EQ(summary["rejected"], 0);
  EXPECT_EQ(summary["durable_sequence"], 30);
  EXPECT_GT(summary["odometry_ms_mean"], 0);
  for (const json& session : Sessions("robots")) {
    if (session["robot"] != "pushed") continue;
    EXPECT_EQ(session["state"], "FINISHED");
    EXPECT_EQ(session["sensor"], "vlp16") << "from simulation.json";
    EXPECT_EQ(session["last_sequence"], 30);
    return;
  }
  FAIL() << "`isthmus robots` does not name the robot";
}

TEST_F(ServerCommandsTest, APartOfAFolderKeepsItsStamps) {
  ASSERT_EQ(Ask("push --robot part --from 10 --to 14 " + Path("robot_0")).code, 0);
  ASSERT_EQ(Ask("trajectory part --frame odom -o " + Path("part.tum")).code, 0);
  const auto part = formats::ReadTum(Path("part.tum"));
  const auto truth = formats::ReadTum(Path("robot_0.truth.tum"));
  ASSERT_TRUE(part.ok() && truth.ok());
  ASSERT_EQ(part->size(), 5u);
  EXPECT_EQ(part->front().stamp_ns, truth->at(10).stamp_ns);
}

TEST_F(ServerCommandsTest, TrajectoriesOfTheBaseAreOfWhatTheSensorIsMountedOn) {
  const Pose T_base_sensor = Pose::FromXyzRpy(0.4, -0.2, 1.1, 0.03, -0.1, 2);
  client::Client& client = server_->client();
  const auto session = client.CreateSession("mounted", "vlp16", T_base_sensor);
  ASSERT_TRUE(session.ok()) << session.status();
  const auto stream = client.OpenScanStream(session->record.id);
  ASSERT_TRUE(stream.ok()) << stream.status();
  for (int i = 0; i < 10; ++i) {
    auto scan = formats::ReadPcd(Path(absl::StrCat("robot_0/00000", i, ".pcd")));
    ASSERT_TRUE(scan.ok()) << scan.status();
    ASSERT_TRUE((*stream)->Push((i + 1) * 100'000'000, std::move(scan->payload)).ok());
  }
  ASSERT_TRUE((*stream)->FinishSession().ok());
  ASSERT_EQ(Ask("status --wait settled --timeout 100").code, 0);
  for (const char* frame : {"odom", "map"}) {
    const std::string command = absl::StrCat("trajectory mounted --frame ", frame);
    ASSERT_EQ(Ask(command + " -o " + Path("sensor.tum")).code, 0);
    const ProgramResult asked = Ask(command + " --poses-of base -o " + Path("base.tum"));
    ASSERT_EQ(asked.code, 0) << asked.err;
    EXPECT_THAT(asked.out, HasSubstr("10 poses of the base of mounted-1"));
    const auto sensor = formats::ReadTum(Path("sensor.tum"));
    const auto base = formats::ReadTum(Path("base.tum"));
    ASSERT_TRUE(sensor.ok() && base.ok());
    ASSERT_EQ(base->size(), 10u);
    for (size_t i = 0; i < base->size(); ++i) {
      EXPECT_EQ(base->at(i).stamp_ns, sensor->at(i).stamp_ns);
      const Pose T_frame_sensor = base->at(i).pose * T_base_sensor;
      EXPECT_TRUE(T_frame_sensor.Matrix().isApprox(sensor->at(i).pose.Matrix(), 1e-6));
    }
    // odom begins at the sensor, and the map of one robot is its odom.
    EXPECT_TRUE(base->front().pose.Matrix().isApprox(T_base_sensor.Inverse().Matrix(), 1e-6));
  }
  ASSERT_EQ(Ask("push --robot unmounted --to 2 " + Path("robot_0")).code, 0);
  const ProgramResult unknown =
      Ask("trajectory unmounted --frame odom --poses-of base -o " + Path("none.tum"));
  EXPECT_EQ(unknown.code, 3);
  EXPECT_THAT(unknown.err,
              HasSubstr("unmounted-1 does not tell how its sensor is mounted on the robot"));
  EXPECT_FALSE(fs::exists(Path("none.tum")));
}

TEST_F(ServerCommandsTest, ScansThatCannotBeUsedAreNamedAndTheOthersGoOn) {
  fs::create_directories(Path("mixed"));
  fs::copy_file(Path("robot_0/000000.pcd"), Path("mixed/0.pcd"));
  std::ofstream(Path("mixed/1.pcd")) << "no PCD at all";
  ASSERT_TRUE(formats::WritePcd(Path("mixed/2.pcd"), codec::MakePayload(Cloud(50, {1, 1, 1, 0})),
                                formats::PcdEncoding::kBinary)
                  .ok());
  fs::copy_file(Path("robot_0/000001.pcd"), Path("mixed/3.pcd"));
  const ProgramResult result = Ask("push --robot mixed --sensor vlp16 --json " + Path("mixed"));
  ASSERT_EQ(result.code, 0) << result.err;
  const json summary = json::parse(result.out);
  EXPECT_EQ(summary["unreadable"], 1);
  EXPECT_EQ(summary["rejected"], 1);
  EXPECT_EQ(summary["processed"], 2);
  EXPECT_THAT(result.err, HasSubstr("left out " + Path("mixed/1.pcd")));
  EXPECT_THAT(result.err, HasSubstr("scan 2 was rejected"));
}

TEST_F(ServerCommandsTest, OnlyUselessScansGiveFive) {
  fs::create_directories(Path("useless"));
  ASSERT_TRUE(formats::WritePcd(Path("useless/0.pcd"), codec::MakePayload(Cloud(50, {1, 1, 1, 0})),
                                formats::PcdEncoding::kBinary)
                  .ok());
  const ProgramResult result = Ask("push --robot useless --sensor vlp16 " + Path("useless"));
  EXPECT_EQ(result.code, 5);
  EXPECT_THAT(result.err, HasSubstr("none of the 1 scans could be used"));
  // Means of no scan are not known. A robot is located in a map that is there.
  ASSERT_EQ(Ask("push --robot mapper " + Path("robot_0")).code, 0);
  for (const char* way : {"", "--localise "}) {
    const ProgramResult nothing =
        Ask(absl::StrCat("push --json --sensor vlp16 --robot useless ", way, Path("useless")));
    EXPECT_EQ(nothing.code, 5) << nothing.err;
    const json summary = json::parse(nothing.out);
    EXPECT_EQ(summary["rejected"], 1);
    for (const char* key :
         {"odometry_ms_mean", "localising_ms_mean", "component", "first_pose_s"}) {
      EXPECT_TRUE(summary.value(key, json()).is_null()) << nothing.out;
    }
  }
}

TEST_F(ServerCommandsTest, LocaliseOnlySaysWhereARobotIs) {
  ASSERT_EQ(Ask("push --robot mapper " + Path("robot_0")).code, 0);
  const json places = AskJson("push --localise --in-map-of mapper --robot guest --poses " +
                              Path("guest.tum") + " --from 5 " + Path("robot_0"));
  EXPECT_EQ(places["scans"], 25);
  EXPECT_GT(places["located"], 10);
  const auto poses = formats::ReadTum(Path("guest.tum"));
  ASSERT_TRUE(poses.ok());
  EXPECT_EQ(poses->size(), places["located"].get<size_t>() + places["uncertain"].get<size_t>());
  for (const json& session : Sessions("robots")) EXPECT_NE(session["robot"], "guest");
  EXPECT_EQ(Ask("push --localise --in-map-of nobody --robot guest " + Path("robot_0")).code, 6);
}

TEST_F(ServerCommandsTest, APushThatIsInterruptedFinishesItsSession) {
  const ProgramResult result = RunProgram(
      "timeout", "--signal=INT 2 " + std::string(ISTHMUS_PROGRAM) + " push --robot cut --rate 4 " +
                     Path("robot_0") + " --server " + server_->client().address());
  EXPECT_THAT(result.err, HasSubstr("interrupted; the session is finished"));
  for (const json& session : Sessions("robots")) {
    if (session["robot"] != "cut") continue;
    EXPECT_EQ(session["state"], "FINISHED");
    EXPECT_LT(session["last_sequence"], 30);
    EXPECT_GT(session["last_sequence"], 0);
  }
}

TEST_F(ServerCommandsTest, WhatTheServerDoesNotKnowGivesSix) {
  for (const char* command : {"transform nobody noone", "trajectory nobody -o /dev/null",
                              "query --robot nobody -o /dev/null",
                              "export --format ply --component 99 -o /dev/shm/never.ply"}) {
    const ProgramResult result = Ask(command);
    EXPECT_EQ(result.code, 6) << command << ": " << result.err;
    EXPECT_FALSE(result.err.empty());
  }
}

TEST_F(ServerCommandsTest, ValuesThatTheServerRefusesGiveTwo) {
  EXPECT_EQ(Ask("query --box 1,1,1,0,0,0 -o " + Path("q.pcd")).code, 2);
  const ProgramResult sensor = Ask("push --robot a --sensor sonar " + Path("robot_0"));
  EXPECT_EQ(sensor.code, 2);
  EXPECT_THAT(sensor.err, HasSubstr("vlp16")) << "the known ones are listed";
  EXPECT_EQ(Ask("push --robot 'a b' " + Path("robot_0")).code, 2);
}

TEST_F(ServerCommandsTest, APersonJoinsTwoRobotsAndPartsThemAgain) {
  ASSERT_EQ(Ask("push --robot hand_a --to 2 " + Path("robot_0")).code, 0);
  ASSERT_EQ(Ask("push --robot hand_b --to 2 " + Path("robot_1")).code, 0);
  const ProgramResult set =
      Ask("match set hand_a hand_b --pose 4 -2 0.5 0 0 90 --note 'measured with a tape'");
  ASSERT_EQ(set.code, 0) << set.err;
  EXPECT_THAT(set.out, HasSubstr("ACCEPTED, BY_HAND (carries the map)\n  given by hand: measured"));
  const json transform = AskJson("transform hand_a hand_b");
  EXPECT_NEAR(transform["t_a_b"]["translation"]["y"].get<double>(), -2, 1e-9);
  EXPECT_NEAR(transform["t_a_b"]["rotation"]["z"].get<double>(), std::sqrt(0.5), 1e-9) << "degrees";
  const json match = AskJson("match reject --sessions hand_b-1 hand_a-1");
  EXPECT_EQ(match["state"], "REJECTED");
  EXPECT_EQ(match["manual_decision"]["kind"], "REJECT");
  EXPECT_EQ(Ask("transform hand_a hand_b").code, 3);
  EXPECT_FALSE(AskJson("match withdraw hand_a hand_b").contains("manual_decision"));
  EXPECT_EQ(Ask("match set hand_a hand_b --pose 1 2 3").code, 2);
}

TEST_F(ServerCommandsTest, RejectingSaysThroughWhomTheTwoStayJoined) {
  for (const char* robot : {"tri_a", "tri_b", "tri_c"}) {
    ASSERT_EQ(Ask("push --to 2 --robot " + std::string(robot) + " " + Path("robot_0")).code, 0);
  }
  ASSERT_EQ(Ask("match set tri_a tri_c --pose 1 0 0 0 0 0").code, 0);
  ASSERT_EQ(Ask("match set tri_b tri_c --pose 1 0 0 0 0 0").code, 0);
  const ProgramResult reject = Ask("match reject tri_a tri_b");
  ASSERT_EQ(reject.code, 0) << reject.err;
  EXPECT_THAT(reject.out, HasSubstr("tri_a-1 and tri_b-1 stay joined, through tri_c-1"));
  const json joined = AskJson("match reject tri_a tri_b");
  EXPECT_EQ(joined["joined"], true);
  EXPECT_EQ(joined["joined_through"], json::array({"tri_c-1"}));
  EXPECT_THAT(Ask("match reject tri_a tri_c").out, HasSubstr("are now in different maps"));
  EXPECT_EQ(AskJson("match reject tri_a tri_b")["joined"], false);
}

TEST_F(ServerCommandsTest, ATransformIsOfSessionsTooWhereTheyAreNamed) {
  for (const char* robot : {"twice_a", "twice_a", "twice_b"}) {
    ASSERT_EQ(Ask("push --to 2 --robot " + std::string(robot) + " " + Path("robot_0")).code, 0);
  }
  ASSERT_EQ(Ask("match set --sessions twice_a-1 twice_b-1 --pose 3 0 0 0 0 0").code, 0);
  EXPECT_NEAR(AskJson("transform twice_a-1 twice_b")["t_a_b"]["translation"]["x"].get<double>(), 3,
              1e-9);
  EXPECT_NEAR(AskJson("transform twice_b-1 twice_a-1")["t_a_b"]["translation"]["x"].get<double>(),
              -3, 1e-9);
  EXPECT_EQ(Ask("transform twice_a-3 twice_b").code, 6);
}

TEST_F(ServerCommandsTest, ASessionOfAProgramThatDiedIsListedFinishedAndDeleted) {
  ASSERT_EQ(Ask("push --no-finish --robot died --to 2 " + Path("robot_0")).code, 0);
  const ProgramResult again = Ask("push --robot died --to 2 " + Path("robot_0"));
  EXPECT_THAT(again.err, HasSubstr("`isthmus session finish died-1`"));
  const auto open = [this] {
    for (const json& session : Sessions("session list --open")) {
      EXPECT_EQ(session["state"], "ACTIVE");
      if (session["id"] == "died-1") return true;
    }
    return false;
  };
  EXPECT_TRUE(open());
  EXPECT_THAT(Ask("session list").out, HasSubstr("died-2"));
  const ProgramResult robot = Ask("session finish died");
  EXPECT_EQ(robot.code, 6);
  EXPECT_THAT(robot.err, HasSubstr("died is a robot: name one of its sessions, died-1, died-2"));
  EXPECT_EQ(AskJson("session finish died-1")["state"], "FINISHED");
  EXPECT_FALSE(open());
  EXPECT_EQ(Ask("session finish died-1").code, 0) << "twice is no error";

  const ProgramResult unsure = Ask("session delete died-1");
  EXPECT_EQ(unsure.code, 2);
  EXPECT_THAT(unsure.err, HasSubstr("--yes"));
  EXPECT_THAT(Ask("session list").out, HasSubstr("died-1"));
  EXPECT_EQ(AskJson("session delete died-1 --yes")["deleted"], "died-1");
  EXPECT_THAT(Ask("session list").out, testing::Not(HasSubstr("died-1")));
  EXPECT_EQ(Ask("session delete died-1 --yes").code, 6);
}

TEST_F(ServerCommandsTest, EveryAnswerAsJsonHasItsVersion) {
  ASSERT_EQ(Ask("push --robot versions --to 5 " + Path("robot_0")).code, 0);
  ASSERT_EQ(Ask("push --robot versions_b --to 5 " + Path("robot_1")).code, 0);
  ASSERT_EQ(Ask("status --wait settled --timeout 100").code, 0);
  for (const char* command :
       {"status", "robots", "session list", "graph", "loops", "revisions", "revisions diff 1",
        "anchor list", "datum show", "match reject versions versions_b",
        "match withdraw versions versions_b", "transform versions versions",
        "anchor set versions-1/0 --position 0 0 0 --sigma-xy 1", "anchor remove versions-1/0"}) {
    EXPECT_TRUE(AskJson(command).is_object()) << command;
  }
  AskJson("push --robot versions --to 2 " + Path("robot_0"));
  AskJson("export --format ply -o " + Path("versions.ply"));
  AskJson("graph --g2o " + Path("versions.g2o"));
}

TEST_F(ServerCommandsTest, AReportRunsNothingThatANoteHolds) {
  ASSERT_EQ(Ask("push --robot page_a --to 2 " + Path("robot_0")).code, 0);
  ASSERT_EQ(Ask("push --robot page_b --to 2 " + Path("robot_1")).code, 0);
  ASSERT_EQ(
      Ask("match set page_a page_b --pose 4 -2 0 0 0 90 --note '<script>alert(1)</script>'").code,
      0);
  ASSERT_EQ(Ask("status --wait settled --timeout 100").code, 0);
  const ProgramResult report = Ask("report --no-figures -o " + Path("report.html"));
  ASSERT_EQ(report.code, 0) << report.err;
  std::stringstream page;
  page << std::ifstream(Path("report.html")).rdbuf();
  EXPECT_THAT(page.str(), HasSubstr("&lt;script&gt;alert(1)"));
  EXPECT_THAT(page.str(), testing::Not(HasSubstr("<script")));
  EXPECT_THAT(page.str(), HasSubstr("page_a-1 ~ page_b-1"));
}

TEST_F(ServerCommandsTest, AMatchByHandIsARevisionThatCanBeUndone) {
  ASSERT_EQ(Ask("push --robot undo_a --to 2 " + Path("robot_0")).code, 0);
  ASSERT_EQ(Ask("push --robot undo_b --to 2 " + Path("robot_1")).code, 0);
  ASSERT_EQ(Ask("status --wait settled --timeout 100").code, 0);
  const int64_t before = AskJson("status")["revision"];
  ASSERT_EQ(Ask("match set undo_a undo_b --pose 4 -2 0.5 0 0 90").code, 0);
  const json revision = AskJson("revisions --limit 1")["revisions"][0];
  EXPECT_GT(revision["revision"], before);
  EXPECT_THAT(revision["cause"].get<std::string>(), HasSubstr("undo_a-1 ~ undo_b-1"));
  const json diff = AskJson("revisions diff " + std::to_string(before));
  EXPECT_EQ(diff["moves"].size(), 1u) << "one came to the other";
  ASSERT_EQ(Ask("transform undo_a undo_b").code, 0);
  const std::string undo = "revisions undo " + revision["revision"].dump();
  EXPECT_GT(AskJson(undo + " --note wrong")["revision"], revision["revision"]);
  EXPECT_EQ(Ask("transform undo_a undo_b").code, 3);
  EXPECT_EQ(Ask(undo).code, 3) << "nothing of it is left";
}

TEST_F(ServerCommandsTest, AnAnchorMovesTheMapToItsPlace) {
  ASSERT_EQ(Ask("push --robot anchored " + Path("robot_0")).code, 0);
  ASSERT_EQ(Ask("status --wait settled --timeout 100").code, 0);
  ASSERT_EQ(Ask("anchor set anchored --position 100 50 2 --rpy-deg 0 0 90 --sigma-xy 0.01 "
                "--sigma-z 0.01 --sigma-deg 0.1")
                .code,
            0);
  ASSERT_EQ(Ask("trajectory anchored -o " + Path("anchored.tum")).code, 0);
  const auto trajectory = formats::ReadTum(Path("anchored.tum"));
  ASSERT_TRUE(trajectory.ok() && !trajectory->empty());
  EXPECT_LT((trajectory->front().pose.translation() - Eigen::Vector3d(100, 50, 2)).norm(), 0.05);
  EXPECT_NEAR(trajectory->front().pose.Yaw(), std::acos(0.0), 0.01);
  const json anchors = AskJson("anchor list")["anchors"];
  ASSERT_EQ(anchors.size(), 1u);
  EXPECT_GT(anchors[0]["given_ns"], 0);

  const json component = Sessions("robots");
  for (const json& session : component) {
    if (session["robot"] != "anchored") continue;
    const std::string file = Path("anchored.g2o"), numbered = Path("numbered.g2o");
    ASSERT_EQ(Ask("graph --map anchored-1 --g2o " + file).code, 0);
    ASSERT_EQ(
        Ask(absl::StrCat("graph --component ", session["component"].dump(), " --g2o ", numbered))
            .code,
        0);
    const auto read = [](const std::string& path) {
      std::ostringstream text;
      text << std::ifstream(path).rdbuf();
      return text.str();
    };
    EXPECT_EQ(read(file), read(numbered));
    EXPECT_EQ(Ask("graph --map anchored-7 --g2o " + numbered).code, 6) << "no such session";
    ASSERT_EQ(Isthmus(absl::StrCat("optimize ", file, " ", file)).code, 0);
    EXPECT_EQ(AskJson("anchor import " + file + " --sigma-xy 1")["anchored"],
              session["submap_count"]);
  }
  EXPECT_EQ(Ask("anchor remove anchored-1/0").code, 0);
  EXPECT_EQ(Ask("anchor remove anchored-1/0").code, 6);
}

TEST_F(ServerCommandsTest, NoAnswerYetGivesThreeAndTheReason) {
  ASSERT_EQ(Ask("push --robot apart_a --to 2 " + Path("robot_0")).code, 0);
  ASSERT_EQ(Ask("push --robot apart_b --to 2 " + Path("robot_1")).code, 0);
  ASSERT_EQ(Ask("status --wait settled --timeout 100").code, 0);
  const ProgramResult transform = Ask("transform apart_a apart_b");
  EXPECT_EQ(transform.code, 3) << transform.out;
  EXPECT_FALSE(transform.err.empty());
  EXPECT_EQ(transform.out, "");
  const ProgramResult merged = Ask("status --wait merged --timeout 0");
  EXPECT_EQ(merged.code, 3) << merged.out;
}

TEST_F(ServerCommandsTest, TheMapCanBeReadInEveryForm) {
  ASSERT_EQ(Ask("push --robot mapped " + Path("robot_0")).code, 0);
  ASSERT_EQ(Ask("status --wait settled --timeout 100").code, 0);
  const json status = AskJson("status");
  EXPECT_EQ(status["settled"], true);
  EXPECT_GT(status["components"][0]["point_count"], 100);

  for (const char* format : {"pcd", "pcd-binary", "pcd-ascii", "ply", "bt", "ot"}) {
    const std::string ending = absl::StartsWith(format, "pcd") ? "pcd" : format;
    const std::string file = Path(absl::StrCat("map.", ending));
    const json summary = AskJson("export --format " + std::string(format) + " -o " + file);
    EXPECT_EQ(summary["size"], fs::file_size(file)) << format;
  }
  ASSERT_EQ(Ask("query --sphere 0,0,0,5 -o " + Path("near.pcd")).code, 0);
  const auto near = formats::ReadPcd(Path("near.pcd"));
  const auto whole = formats::ReadPcd(Path("map.pcd"));
  ASSERT_TRUE(near.ok() && whole.ok()) << near.status() << whole.status();
  EXPECT_GT(near->payload.width, 0u);
  EXPECT_LT(near->payload.width, whole->payload.width);

  const json step = json::parse(Ask("watch --json --steps 1").out);
  EXPECT_EQ(step["restart"], true);
  EXPECT_FALSE(step["tiles"].empty());
  ASSERT_EQ(Ask("query --polygon -3,-3,3,-3,0,4 --max-z 1 -o " + Path("part.pcd")).code, 0);
  EXPECT_LT(formats::ReadPcd(Path("part.pcd"))->payload.width, near->payload.width);
  const ProgramResult few = Ask("query --max-points 50 -o " + Path("few.pcd"));
  EXPECT_THAT(few.out, HasSubstr(", one per "));
  EXPECT_LE(formats::ReadPcd(Path("few.pcd"))->payload.width, 50u);
  ASSERT_EQ(Ask("export --format ply --corridor 0,0,0,2,0,0 --width 2 -o " + Path("way.ply")).code,
            0);
  EXPECT_LT(fs::file_size(Path("way.ply")), fs::file_size(Path("map.ply")));

  ASSERT_EQ(Ask("picture --size 300 -o " + Path("map.png")).code, 0);
  EXPECT_GT(fs::file_size(Path("map.png")), 1000u);
  EXPECT_EQ(Ask("picture --min-z 1000 -o " + Path("empty.png")).code, 3);
  EXPECT_FALSE(fs::exists(Path("empty.png")));
  EXPECT_THAT(Ask("graph --format dot").out, HasSubstr("graph matches {"));
  EXPECT_TRUE(json::parse(Ask("graph --format json").out).contains("matches"));
  EXPECT_TRUE(json::parse(Ask("graph --format nav2").out).at("goals").is_array());
  EXPECT_TRUE(json::parse(Ask("graph --format vda5050").out).at("orders").is_array());
  const ProgramResult graph = Ask("graph");
  EXPECT_EQ(graph.code, 0);
  EXPECT_THAT(graph.out, HasSubstr("map 0, in the frame of "));
  EXPECT_THAT(graph.out, HasSubstr("the reference"));
}

}  // namespace
}  // namespace isthmus::cli
