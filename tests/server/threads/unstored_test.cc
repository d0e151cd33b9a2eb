// A disk that is full just when matching has found something: it is stored once there is room.
#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <string>
#include <thread>
#include <utility>

#include "storage/forwarding_store.h"
#include "tests/server/pipeline/robots.h"

namespace isthmus::server {
namespace {

struct Disk {
  std::atomic<bool> is_full = true;  // For matches: all else still fits.
  std::atomic<int> refused = 0;
};

class NearlyFullStore : public storage::ForwardingStore {
 public:
  explicit NearlyFullStore(std::shared_ptr<Disk> disk)
      : ForwardingStore(storage::MakeMemoryStore()), disk_(std::move(disk)) {}
  absl::Status Write(const storage::WriteBatch& batch) override {
    if (!disk_->is_full || batch.matches.empty()) return ForwardingStore::Write(batch);
    ++disk_->refused;
    return absl::ResourceExhaustedError("the disk is full");
  }

 private:
  const std::shared_ptr<Disk> disk_;
};

class UnstoredTest : public testing::Test {
 protected:
  UnstoredTest() {
    pipeline_ = Pipeline::Open(QuickOptions(), std::make_unique<NearlyFullStore>(disk_)).value();
    const Drive drive(2);
    for (int robot = 0; robot < 2; ++robot) {
      const SessionId session = pipeline_->sessions()
                                    .Create({RobotId(robot == 0 ? "a" : "b"), "vlp16"})
                                    .value()
                                    .record.id;
      EXPECT_TRUE(drive.Submit(*pipeline_, session, 0, 6, robot).ok());
      EXPECT_TRUE(pipeline_->sessions().Finish(session).ok());
    }
    while (disk_->refused == 0) std::this_thread::yield();
  }

  const std::shared_ptr<Disk> disk_ = std::make_shared<Disk>();
  std::unique_ptr<Pipeline> pipeline_;
};

TEST_F(UnstoredTest, AMatchFoundWhileTheDiskIsFullIsThereOnceThereIsRoom) {
  EXPECT_TRUE(pipeline_->reader().GetMatchGraph().matches.empty());
  disk_->is_full = false;
  pipeline_->WaitUntilIdle();
  EXPECT_EQ(pipeline_->reader().GetMatchGraph().matches.size(), 1u);
  EXPECT_EQ(pipeline_->GetMapInfo().storage_problem, "");
}

TEST_F(UnstoredTest, NothingSettlesMeanwhile) {
  while (disk_->refused < 3) std::this_thread::yield();
  EXPECT_FALSE(pipeline_->GetMapInfo().settled);
  EXPECT_NE(pipeline_->GetMapInfo().storage_problem, "");
}

TEST_F(UnstoredTest, AServerThatIsStoppedDoesNotWaitForRoom) {
  pipeline_ = nullptr;
  EXPECT_GT(disk_->refused, 0);
}

}  // namespace
}  // namespace isthmus::server
