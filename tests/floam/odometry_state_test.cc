// An odometry that is saved and restored goes on exactly as one that was not.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "core/state_codec.h"
#include "floam/odometry.h"
#include "floam/odometry_options.h"
#include "floam/state/unfinished_submap.h"
#include "floam/submap_builder.h"
#include "tests/floam/building.h"

namespace isthmus::floam {
namespace {

using testing::FurnishedRoom;
using testing::Loop;
using testing::MakeScan;
using testing::Motion;
using testing::Room;
using testing::Sensor;

// The state that a session's worker keeps of a drive, and all its output, as bytes.
class Session {
 public:
  Session(const std::string& sensor, const OdometryOptions& options)
      : sensor_(*FindSensorModel(sensor)), options_(options) {
    Begin();
  }

  void Process(const Scan& scan) {
    const auto result = odometry_->Process(scan);
    StateWriter out;
    out(result.ok());
    if (result.ok()) {
      lost_ += result->status == TrackingStatus::kLost ? 1 : 0;
      degenerate_ += result->status == TrackingStatus::kDegenerate ? 1 : 0;
      found_ = lost_ > 0 && result->status == TrackingStatus::kOk;
      out(result->status, result->T_odom_sensor, result->covariance, result->matched_covariance,
          result->unobserved_covariance, result->input.rings, result->input.times);
      for (const Point& p : result->undistorted) out(p.x, p.y, p.z);
      if (std::shared_ptr<const Submap> submap = builder_->Add(*result)) {
        odometry_->Remember(*submap);
        WriteUnfinished(*submap, out);
        submaps_.push_back(std::move(submap));
      }
    }
    results_.push_back(out.Take());
  }

  // As after a crash: all is new but what was stored.
  void SaveAndRestore() {
    const std::string odometry = odometry_->Save(), builder = builder_->Save();
    Begin();
    for (const auto& submap : submaps_) odometry_->Remember(*submap);
    ASSERT_TRUE(odometry_->Restore(odometry).ok());
    ASSERT_TRUE(builder_->Restore(builder).ok());
    EXPECT_EQ(odometry_->Save(), odometry);
    EXPECT_EQ(builder_->Save(), builder);
  }

  Odometry& odometry() { return *odometry_; }
  SubmapBuilder& builder() { return *builder_; }
  const std::vector<std::string>& results() const { return results_; }
  size_t submap_count() const { return submaps_.size(); }
  int lost() const { return lost_; }
  int degenerate() const { return degenerate_; }
  bool found() const { return found_; }  // After it was lost.

 private:
  void Begin() {
    SubmapOptions submap;
    submap.cut_distance_m = 3;
    submap.cut_scans = 40;
    odometry_ = std::make_unique<Odometry>(sensor_, options_);
    builder_ = std::make_unique<SubmapBuilder>(SessionId("alice-1"), RobotId("alice"), submap);
  }

  const SensorModel sensor_;
  const OdometryOptions options_;
  std::unique_ptr<Odometry> odometry_;
  std::unique_ptr<SubmapBuilder> builder_;
  std::vector<std::shared_ptr<const Submap>> submaps_;
  std::vector<std::string> results_;
  int lost_ = 0, degenerate_ = 0;
  bool found_ = false;
};

OdometryOptions WithMode(OdometryMode mode) {
  OdometryOptions options;
  options.mode = mode;
  return options;
}

// Runs the drive undisturbed and with restarts before the scans named; the results, and all that is
// known at the end, must be the same to the last bit. The undisturbed one, for a look at it.
std::unique_ptr<Session> ExpectSameWithRestarts(const std::vector<Scan>& scans,
                                                const std::set<size_t>& restarts,
                                                const std::string& sensor, OdometryMode mode) {
  auto undisturbed = std::make_unique<Session>(sensor, WithMode(mode));
  Session restarted(sensor, WithMode(mode));
  for (size_t k = 0; k < scans.size(); ++k) {
    if (restarts.count(k) > 0) restarted.SaveAndRestore();
    undisturbed->Process(scans[k]);
    restarted.Process(scans[k]);
    EXPECT_EQ(undisturbed->results().back(), restarted.results().back()) << k;
    if (::testing::Test::HasFailure()) return undisturbed;
  }
  EXPECT_EQ(undisturbed->odometry().Save(), restarted.odometry().Save());
  EXPECT_EQ(undisturbed->builder().Save(), restarted.builder().Save());
  return undisturbed;
}

std::set<size_t> RandomScans(size_t count, size_t of, uint32_t seed) {
  std::mt19937 random(seed);
  std::set<size_t> scans;
  while (scans.size() < count) scans.insert(random() % of);
  return scans;
}

// A loop in a room with what happens to scans on the way: some are dropped, some show nothing, and
// for a while something stands right before the sensor.
std::vector<Scan> TroubledLoop() {
  Room elsewhere;
  elsewhere.walls = {{-1.9, -0.8, -0.5}, {0.7, 2.4, 0.6}};
  const Room room = FurnishedRoom();
  const Sensor sensor;
  std::vector<Scan> scans;
  for (int k = 0; k < 90; ++k) {
    if (k == 22 || k == 23) continue;
    const bool blocked = k >= 50 && k < 60;
    scans.push_back(blocked ? MakeScan(
                                  elsewhere, [](double) { return Pose(); }, sensor, k)
                            : MakeScan(room, Loop(1.2), sensor, k));
    if (k == 30) scans.back().points.resize(40);
  }
  return scans;
}

std::vector<Scan> Bare(std::vector<Scan> scans) {
  for (Scan& scan : scans) scan.has_ring = scan.has_time = false;
  return scans;
}

class OdometryState : public ::testing::TestWithParam<OdometryMode> {};

INSTANTIATE_TEST_SUITE_P(All, OdometryState,
                         ::testing::Values(OdometryMode::kContinuous, OdometryMode::kFloam,
                                           OdometryMode::kAloam),
                         [](const auto& param) { return ToString(param.param); });

TEST_P(OdometryState, GoesOnExactlyThroughTroubles) {
  const std::vector<Scan> scans = TroubledLoop();
  std::set<size_t> restarts = RandomScans(9, scans.size(), 7);
  restarts.insert({0, 1, 2, 52, 60});  // At the beginning, while lost, and when found again.
  const auto run = ExpectSameWithRestarts(scans, restarts, "vlp16", GetParam());
  EXPECT_GE(run->lost(), 10);
  EXPECT_TRUE(run->found());
  EXPECT_GE(run->submap_count(), 2u);
}

TEST_P(OdometryState, GoesOnExactlyWithInferredRingsAndTimes) {
  std::vector<Scan> scans = Bare(TroubledLoop());
  scans.resize(25);
  ExpectSameWithRestarts(scans, {1, 2, 3, 11, 19}, "spinning", GetParam());
}

TEST_P(OdometryState, GoesOnExactlyWithoutRings) {
  std::vector<Scan> scans;
  for (int k = 0; k < 25; ++k) {
    scans.push_back(
        testing::MakeScanWithoutRings(FurnishedRoom(), Loop(1.2), testing::Scattered, 8000, k));
  }
  for (const char* sensor : {"mid360", "spinning"}) {
    ExpectSameWithRestarts(scans, {1, 2, 3, 11, 19}, sensor, GetParam());
  }
}

TEST_P(OdometryState, GoesOnExactlyAlongABareCorridor) {
  Room corridor;
  corridor.walls = {{-400, -5, -1.2}, {400, 5, 8}};
  std::vector<Scan> scans;
  const auto along = [](double time_s) { return Pose(Eigen::Vector3d(-30 + 1.5 * time_s, 0, 0)); };
  for (int k = 0; k < 60; ++k) scans.push_back(MakeScan(corridor, along, Sensor(), k));
  const auto run =
      ExpectSameWithRestarts(scans, RandomScans(8, scans.size(), 3), "vlp16", GetParam());
  EXPECT_GE(run->degenerate(), 3);
}

// Found again only by a search in all that was remembered, which takes several scans.
TEST(OdometryKidnapped, GoesOnExactlyWhileItIsLookedFor) {
  const Room building = testing::ThreeRooms();
  std::vector<Scan> scans;
  const auto there = [](double time_s) {
    const double moving = std::clamp(time_s - 0.5, 0.0, 1.0);
    const double along = 0.75 * moving * moving + 1.5 * std::max(0.0, time_s - 1.5);
    return Pose::FromXyzRpy(-15 + along, 0.3 * std::sin(along / 3), 0, 0, 0,
                            0.1 * std::cos(along / 3) - 0.1);
  };
  for (int k = 0; k < 210; ++k) scans.push_back(MakeScan(building, there, Sensor(), k));
  const size_t kidnapped = scans.size();
  const Pose put_down = Pose::FromXyzRpy(-11.5, -1.4, 0, 0, 0, 2.2);
  const auto on = [&](double time_s) {
    return put_down * Pose(Eigen::Vector3d(0.3 * std::max(0.0, time_s - 24), 0, 0));
  };
  for (int k = 220; k < 260; ++k) scans.push_back(MakeScan(building, on, Sensor(), k));
  std::set<size_t> restarts = RandomScans(4, kidnapped, 5);
  for (size_t k = kidnapped + 1; k < kidnapped + 25; k += 2) restarts.insert(k);
  const auto run = ExpectSameWithRestarts(scans, restarts, "vlp16", OdometryMode::kContinuous);
  EXPECT_GE(run->lost(), 5);
  EXPECT_TRUE(run->found());
}

// --- states that are none ---

struct Saved {
  std::unique_ptr<Session> session;
  std::string odometry, builder;
};

Saved SaveAfter(int scans, OdometryMode mode = OdometryMode::kContinuous) {
  Saved saved;
  saved.session = std::make_unique<Session>("vlp16", WithMode(mode));
  for (int k = 0; k < scans; ++k) {
    saved.session->Process(MakeScan(FurnishedRoom(), Loop(1), Sensor(), k));
  }
  saved.odometry = saved.session->odometry().Save();
  saved.builder = saved.session->builder().Save();
  return saved;
}

bool IsRefusal(const absl::Status& status) {
  return absl::IsDataLoss(status) || absl::IsInvalidArgument(status);
}

TEST(OdometryStateDamaged, IsRefusedAndChangesNothing) {
  const Saved saved = SaveAfter(8);
  Session other("vlp16", WithMode(OdometryMode::kContinuous));
  for (int k = 0; k < 3; ++k) other.Process(MakeScan(FurnishedRoom(), Loop(2), Sensor(), k));
  const std::string before = other.odometry().Save(), builder_before = other.builder().Save();
  std::mt19937 random(1);
  for (int k = 0; k < 300; ++k) {
    for (std::string state : {saved.odometry, saved.builder}) {
      if (k % 3 == 0) {
        state.resize(random() % state.size());
      } else if (k % 3 == 1) {
        state[random() % state.size()] ^= static_cast<char>(1 << random() % 8);
      } else {
        const size_t size = random() % 4000;
        state.resize(size);
        for (char& c : state) c = static_cast<char>(random());
      }
      EXPECT_TRUE(IsRefusal(other.odometry().Restore(state)));
      EXPECT_TRUE(IsRefusal(other.builder().Restore(state)));
    }
  }
  EXPECT_TRUE(IsRefusal(other.odometry().Restore(saved.odometry + "x")));
  EXPECT_EQ(other.odometry().Save(), before);
  EXPECT_EQ(other.builder().Save(), builder_before);
}

// Even where the checksum is made to fit: the restored state may be nonsense, but never crashes.
TEST(OdometryStateDamaged, NeverCrashesWhereTheChecksumFits) {
  constexpr size_t kHeader = 24;
  const Scan next = MakeScan(FurnishedRoom(), Loop(1), Sensor(), 9);
  std::mt19937 random(2);
  const auto reseal = [](std::string* state) {
    const uint64_t checksum = StateChecksum(state->data() + kHeader, state->size() - kHeader);
    std::memcpy(state->data() + 16, &checksum, sizeof(checksum));
  };
  int refused = 0, taken = 0;
  for (const int scans : {1, 8}) {
    const Saved saved = SaveAfter(scans, OdometryMode::kAloam);
    for (int k = 0; k < 400; ++k) {
      std::string odometry = saved.odometry, builder = saved.builder;
      for (std::string* state : {&odometry, &builder}) {
        const size_t within = k % 2 == 0 ? std::min<size_t>(state->size(), 4000) : state->size();
        const size_t at = kHeader + random() % (within - kHeader);
        const size_t size = std::min<size_t>(1 + random() % 8, state->size() - at);
        for (size_t i = 0; i < size; ++i) {
          (*state)[at + i] = static_cast<char>(k % 4 < 2 ? 0xff : random());
        }
        reseal(state);
      }
      Session session("vlp16", WithMode(OdometryMode::kAloam));
      const absl::Status status = session.odometry().Restore(odometry);
      (status.ok() ? taken : refused) += 1;
      EXPECT_TRUE(status.ok() || IsRefusal(status)) << status;
      const bool also_builder = session.builder().Restore(builder).ok();
      if (status.ok() && also_builder && k % 10 == 0) session.Process(next);
    }
  }
  EXPECT_GT(refused, 50);
  EXPECT_GT(taken, 50);
}

TEST(OdometryStateDamaged, OfOtherSettingsIsRefused) {
  const Saved saved = SaveAfter(3);
  OdometryOptions options = WithMode(OdometryMode::kContinuous);
  options.map_distance_m *= 2;
  Session changed("vlp16", options);
  EXPECT_TRUE(absl::IsInvalidArgument(changed.odometry().Restore(saved.odometry)));
  Session other_mode("vlp16", WithMode(OdometryMode::kFloam));
  EXPECT_TRUE(absl::IsInvalidArgument(other_mode.odometry().Restore(saved.odometry)));
  Session other_sensor("hdl32", WithMode(OdometryMode::kContinuous));
  EXPECT_TRUE(absl::IsInvalidArgument(other_sensor.odometry().Restore(saved.odometry)));
  SubmapBuilder other_session(SessionId("bob-1"), RobotId("bob"), SubmapOptions());
  EXPECT_TRUE(absl::IsInvalidArgument(other_session.Restore(saved.builder)));
}

}  // namespace
}  // namespace isthmus::floam
