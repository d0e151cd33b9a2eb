// A server that is told to stop while it works on the worst that robots can upload.
#include <absl/strings/str_cat.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <memory>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "client/library/client.h"
#include "core/stopwatch.h"
#include "tests/faults/harness/or_throw.h"
#include "tests/faults/harness/robot.h"
#include "tests/faults/harness/server_process.h"
#include "tests/faults/harness/test_setup.h"

namespace isthmus::faults {
namespace {

#ifdef __SANITIZE_ADDRESS__
constexpr double kSoonMs = 60'000;  // A process that has ended looks for leaks in all that it had.
#else
constexpr double kSoonMs = 8000;  // On a machine that is busy with other tests.
#endif

// A point as it is sent.
struct SeenPoint {
  float x, y, z;
  uint32_t keyframe;
};

// On the walls, floor and ceiling of a room of 10 x 8 x 3 m.
SeenPoint OnSomeWall(std::mt19937* rng, double room_x, uint32_t keyframe) {
  std::uniform_real_distribution<float> share(0, 1);
  const float edge[3] = {10, 8, 3};
  float p[3] = {edge[0] * share(*rng), edge[1] * share(*rng), edge[2] * share(*rng)};
  const unsigned axis = (*rng)() % 3;
  p[axis] = (*rng)() % 2 == 0 ? 0 : edge[axis];
  return {p[0] + static_cast<float>(room_x), p[1], p[2], keyframe};
}

// Rooms in a row; the sensor stood `keyframes` times, by turns in each.
SubmapUpload Rooms(const SubmapId& id, int rooms, double apart_m, uint32_t keyframes,
                   int points_each, unsigned seed) {
  std::mt19937 rng(seed);
  SubmapUpload upload;
  upload.id = id;
  upload.first_stamp_ns = 1'000'000'000;
  std::vector<SeenPoint> points;
  for (uint32_t k = 0; k < keyframes; ++k) {
    const double room_x = apart_m * static_cast<double>(k % static_cast<uint32_t>(rooms));
    const int64_t stamp_ns = upload.first_stamp_ns + int64_t{100'000'000} * k;
    const double angle = 0.01 * k;
    upload.keyframes.push_back(
        {stamp_ns, Pose(Eigen::Vector3d(room_x + 5 + std::sin(angle), 4 + std::cos(angle), 1))});
    upload.last_stamp_ns = stamp_ns;
    for (int i = 0; i < points_each; ++i) points.push_back(OnSomeWall(&rng, room_x, k));
  }
  upload.cloud.width = static_cast<uint32_t>(points.size());
  upload.cloud.stride = sizeof(SeenPoint);
  upload.cloud.fields = {{"x", 0, ScalarType::kFloat32},
                         {"y", 4, ScalarType::kFloat32},
                         {"z", 8, ScalarType::kFloat32},
                         {"keyframe", 12, ScalarType::kUint32}};
  upload.cloud.data.resize(points.size() * sizeof(SeenPoint));
  std::memcpy(upload.cloud.data.data(), points.data(), upload.cloud.data.size());
  return upload;
}

class StopTest : public testing::Test {
 protected:
  std::unique_ptr<client::Client> Connect() const {
    return OrThrow(client::Client::Connect(PatientClient(server_.address())));
  }

  // Two robots, with the same two submaps each.
  void UploadTheWorst() {
    const auto client = Connect();
    for (int robot = 0; robot < 2; ++robot) {
      const SessionId session =
          OrThrow(client->CreateSession(absl::StrCat("r", robot), "vlp16")).record.id;
      const absl::Status many =
          client->UploadSubmap(Rooms({session, 0}, 20, 12, 65535, 4, 1 + robot));
      EXPECT_TRUE(many.ok()) << many;
      const absl::Status far = client->UploadSubmap(Rooms({session, 1}, 2, 3000, 40, 5000, 7));
      EXPECT_TRUE(far.ok()) << far;
    }
  }
  // Until matching has something at hand, or has done everything.
  void WaitUntilItIsAtWork() {
    const auto client = Connect();
    const auto is_at_work = [this] {
      std::ifstream journal(server_.data() + "/matching.journal");
      const std::string text((std::istreambuf_iterator<char>(journal)), {});
      return text.find("at_hand") != std::string::npos;
    };
    while (!is_at_work() && !OrThrow(client->GetMapInfo()).settled) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }
  void StartSoon() {
    const Stopwatch watch;
    ASSERT_TRUE(server_.Start()) << server_.Log();
    EXPECT_LT(watch.Ms(), kSoonMs);
  }
  void StopSoon() {
    const Stopwatch watch;
    EXPECT_EQ(server_.Stop(), 0) << server_.Log();
    EXPECT_LT(watch.Ms(), kSoonMs) << server_.Log();
  }

  const TestSetup setup_;
  ServerProcess server_{setup_.get().server, setup_.Path("server")};
};

TEST_F(StopTest, SigtermEndsAServerAtWorkOnTheWorstUploadsAndItServesAgain) {
  ASSERT_NO_FATAL_FAILURE(StartSoon());
  ASSERT_NO_THROW(UploadTheWorst());
  WaitUntilItIsAtWork();
  StopSoon();
  ASSERT_NO_FATAL_FAILURE(StartSoon());
  StopSoon();  // At what is made after a start, the merged map.
  ASSERT_NO_FATAL_FAILURE(StartSoon());
  const auto client = Connect();
  const MapInfo info = OrThrow(client->GetMapInfo());
  EXPECT_EQ(info.submaps, 4u);
  EXPECT_THAT(info.damaged, testing::IsEmpty());
  WaitUntilItIsAtWork();
  StopSoon();
  EXPECT_EQ(server_.Log().find("left out"), std::string::npos) << server_.Log();
}

}  // namespace
}  // namespace isthmus::faults
