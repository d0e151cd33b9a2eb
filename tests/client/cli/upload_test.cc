// `isthmus upload` against a real server over a socket.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "client/offline/embedded_server.h"
#include "core/formats/pcd.h"
#include "core/formats/tum.h"
#include "tests/client/cli/program.h"

namespace isthmus::cli {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::HasSubstr;

// robot_1's own SLAM began elsewhere.
const Pose kOwnFrame = Pose::FromXyzRpy(30, -12, 2, 0, 0, 2.0);

class UploadTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = ScratchFolder();
    auto server = EmbeddedServer::Start({});
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
  }

  void TearDown() override { fs::remove_all(folder_); }

  void Simulate(int robots, int seconds) {
    const ProgramResult simulated =
        Isthmus("simulate --world museum --seed 1 --robots " + std::to_string(robots) +
                " --seconds " + std::to_string(seconds) + " -o " + folder_);
    ASSERT_EQ(simulated.code, 0) << simulated.err;
  }
  // The truth of a robot as its own SLAM would have it.
  Trajectory WriteOwn(const std::string& robot, const std::string& name) {
    auto own = formats::ReadTum(Path(robot + ".truth.tum"));
    EXPECT_TRUE(own.ok()) << own.status();
    for (StampedPose& pose : *own) pose.pose = kOwnFrame * pose.pose;
    EXPECT_TRUE(formats::WriteTum(Path(name), *own).ok());
    return *own;
  }
  std::string Path(const std::string& name) const { return folder_ + "/" + name; }
  ProgramResult Ask(const std::string& command) const {
    return Isthmus(command + " --server " + server_->client().address());
  }
  json AskJson(const std::string& command) const {
    const ProgramResult result = Ask(command + " --json");
    EXPECT_EQ(result.code, 0) << result.err;
    return json::parse(result.out, nullptr, false);
  }
  std::vector<SubmapStatus> SubmapsOf(const std::string& robot) const {
    const auto submaps = server_->client().ListSubmaps(RobotId(robot));
    EXPECT_TRUE(submaps.ok()) << submaps.status();
    return *submaps;
  }

  std::unique_ptr<EmbeddedServer> server_;
  std::string folder_;
};

// Starts the upload with nobody who reads its complaints; kills it as soon as the server has a
// submap.
void UploadAndKill(const std::vector<std::string>& arguments, client::Client& client,
                   const std::string& robot) {
  int complaints[2];
  ASSERT_EQ(pipe(complaints), 0);
  ASSERT_GT(fcntl(complaints[1], F_SETPIPE_SZ, 4096), 0);
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    dup2(complaints[1], STDERR_FILENO);
    std::vector<char*> words = {const_cast<char*>("isthmus")};
    for (const std::string& argument : arguments)
      words.push_back(const_cast<char*>(argument.c_str()));
    words.push_back(nullptr);
    execv(ISTHMUS_PROGRAM, words.data());
    _exit(127);
  }
  bool has_submap = false;
  while (!has_submap && waitpid(child, nullptr, WNOHANG) == 0) {
    const auto submaps = client.ListSubmaps(RobotId(robot));
    has_submap = submaps.ok() && !submaps->empty();
    std::this_thread::yield();
  }
  EXPECT_TRUE(has_submap);
  EXPECT_EQ(kill(child, SIGKILL), 0);
  int status = 0;
  EXPECT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFSIGNALED(status)) << "it was in the middle";
  close(complaints[0]);
  close(complaints[1]);
}

TEST_F(UploadTest, TwoRobotsWithTheirOwnSlamAreMerged) {
  ASSERT_NO_FATAL_FAILURE(Simulate(2, 40));
  const Trajectory own = WriteOwn("robot_1", "own.tum");
  const json a =
      AskJson("upload --robot a --poses " + Path("robot_0.truth.tum") + " " + Path("robot_0"));
  EXPECT_EQ(a["clouds"], 400);
  EXPECT_EQ(a["without_pose"], 0);
  EXPECT_GE(a["submaps"], 2);
  EXPECT_EQ(a["finished"], true);
  ASSERT_EQ(Ask("upload --robot b --poses " + Path("own.tum") + " " + Path("robot_1")).code, 0);
  const ProgramResult merged = Ask("status --wait merged --timeout 300");
  ASSERT_EQ(merged.code, 0) << merged.out << Ask("graph").out;
  const json transform = AskJson("transform a b")["t_a_b"];
  const auto& t = transform["translation"];
  const auto& q = transform["rotation"];
  const Pose T_a_b(Eigen::Quaterniond(q["w"], q["x"], q["y"], q["z"]),
                   Eigen::Vector3d(t["x"], t["y"], t["z"]));
  const Pose error = T_a_b * kOwnFrame;
  EXPECT_LT(RotationAngle(error), 0.05) << "3 degrees";
  // On its own path: farther away an error of half a degree is any number of metres.
  for (const StampedPose& pose : own) {
    const Eigen::Vector3d there = pose.pose.translation();
    EXPECT_LT((T_a_b * there - kOwnFrame.Inverse() * there).norm(), 0.3);
  }
  ASSERT_EQ(Ask("trajectory a -o " + Path("a.tum")).code, 0);
  ASSERT_EQ(Ask("trajectory b -o " + Path("b.tum")).code, 0);
  const ProgramResult eval =
      Isthmus("eval --merged --json --truth " + Path("robot_0.truth.tum") + " " +
              Path("robot_1.truth.tum") + " --estimate " + Path("a.tum") + " " + Path("b.tum"));
  ASSERT_EQ(eval.code, 0) << eval.err;
  EXPECT_LT(json::parse(eval.out)["merged"]["rmse_m"], 0.2) << eval.out;

  const ProgramResult again =
      Ask("upload --robot a --poses " + Path("robot_0.truth.tum") + " " + Path("robot_0"));
  EXPECT_EQ(again.code, 0) << again.err;
  EXPECT_THAT(again.err, HasSubstr("nothing left to upload"));
  EXPECT_EQ(AskJson("robots")["sessions"].size(), 2u) << "no new session";
}

TEST_F(UploadTest, TheSameCommandGoesOnAfterAKill) {
  ASSERT_NO_FATAL_FAILURE(Simulate(1, 30));
  // The scans in which the robot is killed cannot be read, of which it complains until its pipe is
  // full: it waits there, behind the first submap.
  fs::copy(Path("robot_0"), Path("broken"), fs::copy_options::recursive);
  for (int i = 240; i < 300; ++i) {
    std::ofstream(Path("broken/000" + std::to_string(i) + ".pcd")) << "no PCD";
  }
  const std::string poses = Path("robot_0.truth.tum");
  UploadAndKill({"upload", "--robot", "killed", "--poses", poses, Path("broken"), "--server",
                 server_->client().address()},
                server_->client(), "killed");
  const size_t had = SubmapsOf("killed").size();
  const std::string rest = " --poses " + poses + " " + Path("broken");
  const json resumed = AskJson("upload --robot killed" + rest);
  EXPECT_EQ(resumed["session"], "killed-1");
  EXPECT_GE(resumed["before"], had);
  EXPECT_GT(resumed["submaps"], resumed["before"]);
  EXPECT_EQ(resumed["unreadable"], 60);
  EXPECT_EQ(AskJson("upload --robot whole" + rest)["before"], 0);
  const auto killed = SubmapsOf("killed"), whole = SubmapsOf("whole");
  ASSERT_EQ(killed.size(), whole.size());
  for (size_t i = 0; i < whole.size(); ++i) {
    EXPECT_EQ(killed[i].info.id.index, whole[i].info.id.index);
    EXPECT_EQ(killed[i].info.point_count, whole[i].info.point_count);
    EXPECT_EQ(killed[i].info.keyframe_count, whole[i].info.keyframe_count);
    EXPECT_EQ(killed[i].info.last_stamp_ns, whole[i].info.last_stamp_ns);
    EXPECT_TRUE(
        killed[i].info.T_odom_submap.Matrix().isApprox(whole[i].info.T_odom_submap.Matrix()));
  }
}

TEST_F(UploadTest, AnOpenSessionGoesOnByNameToo) {
  ASSERT_NO_FATAL_FAILURE(Simulate(1, 3));
  const std::string rest = " --to 20 --poses " + Path("robot_0.truth.tum") + " " + Path("robot_0");
  EXPECT_EQ(AskJson("upload --robot o --no-finish" + rest)["finished"], false);
  const json named = AskJson("upload --robot o --session o-1" + rest);
  EXPECT_EQ(named["before"], 1);
  EXPECT_EQ(named["finished"], true);
  EXPECT_EQ(Ask("upload --robot o --session o-9" + rest).code, 6);
  EXPECT_EQ(Ask("upload --robot other --session o-1" + rest).code, 2);
  const ProgramResult differs = Ask("upload --robot o --voxel 0.3 --session o-1" + rest);
  EXPECT_EQ(differs.code, 1) << differs.out;
  EXPECT_THAT(differs.err, HasSubstr("other content"));
}

TEST_F(UploadTest, ViewpointsOfCloudsAreTheirPoses) {
  ASSERT_NO_FATAL_FAILURE(Simulate(1, 1));
  const Trajectory steps = {{0, kOwnFrame},
                            {0, Pose::FromXyzRpy(31.5, -12, 2, 0, 0, 2)},
                            {0, Pose::FromXyzRpy(33, -12, 2, 0, 0, 2)}};
  fs::create_directories(Path("views"));
  for (size_t i = 0; i < 3; ++i) {
    const std::string name = "/00000" + std::to_string(i) + ".pcd";
    const auto pcd = formats::ReadPcd(Path("robot_0") + name);
    ASSERT_TRUE(pcd.ok()) << pcd.status();
    ASSERT_TRUE(formats::WritePcd(Path("views") + name, pcd->payload, formats::PcdEncoding::kBinary,
                                  steps[i].pose)
                    .ok());
  }
  EXPECT_EQ(AskJson("upload --robot seen " + Path("views"))["keyframes"], 3);
  const auto submaps = SubmapsOf("seen");
  ASSERT_FALSE(submaps.empty());
  EXPECT_TRUE(submaps[0].info.T_odom_submap.Matrix().isApprox(kOwnFrame.Matrix(), 1e-5));

  // In order, where clouds have no times: the poses of a graph.
  std::ofstream graph(Path("views.g2o"));
  for (int i = 0; i < 3; ++i) {
    graph << "VERTEX_SE3:QUAT " << i << " " << 2 * i << " 0 0 0 0 0 1\n";
  }
  graph.close();
  const ProgramResult paired =
      Ask("upload --robot paired --json --poses " + Path("views.g2o") + " " + Path("views"));
  EXPECT_EQ(paired.code, 0) << paired.err;
  EXPECT_THAT(paired.err, HasSubstr("paired in order"));
  EXPECT_NEAR(json::parse(paired.out)["travelled_m"], 4, 1e-6);
}

TEST_F(UploadTest, WhatCannotBeUsedSaysWhy) {
  ASSERT_NO_FATAL_FAILURE(Simulate(1, 3));
  const std::string folder = Path("robot_0"), truth = Path("robot_0.truth.tum");
  const ProgramResult bare = Ask("upload --robot n --to 3 " + folder);
  EXPECT_EQ(bare.code, 5);
  EXPECT_THAT(bare.err, HasSubstr("--poses")) << "the VIEWPOINTs are the identity";
  std::ofstream(Path("other.tum")) << "5 0 0 0 0 0 0 1\n6 0 0 0 0 0 0 1\n";
  const ProgramResult other = Ask("upload --robot n --poses " + Path("other.tum") + " " + folder);
  EXPECT_EQ(other.code, 5);
  EXPECT_THAT(other.err, HasSubstr("poses from 5.000 to 6.000 s"));
  std::ofstream(Path("bad.tum")) << "5 0 0 0 0 0 0 1\n6 zero 0 0 0 0 0 1\n";
  const ProgramResult bad = Ask("upload --robot n --poses " + Path("bad.tum") + " " + folder);
  EXPECT_EQ(bad.code, 5);
  EXPECT_THAT(bad.err, HasSubstr("bad.tum: line 2"));
  EXPECT_EQ(Ask("upload --robot n --poses /no/such " + folder).code, 5);
  EXPECT_EQ(Ask("upload --robot n --poses " + truth + " /no/such").code, 5);
  EXPECT_EQ(Ask("upload --robot n --max-range 0 --poses " + truth + " " + folder).code, 2);
  EXPECT_EQ(Ask("upload --robot n --clouds-in map --poses " + truth + " " + folder).code, 2);
  EXPECT_EQ(Ask("upload --robot 'n n' --poses " + truth + " " + folder).code, 2);
  EXPECT_EQ(
      Isthmus("upload --attempts 1 --server localhost:1 --robot n --poses " + truth + " " + folder)
          .code,
      4);
  EXPECT_EQ(AskJson("robots")["sessions"].size(), 0u) << "no session was opened";
}

}  // namespace
}  // namespace isthmus::cli
