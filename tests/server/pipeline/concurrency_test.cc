// Robots, readers and operators at work at the same time. Most telling under ThreadSanitizer.
#include <gtest/gtest.h>

#include <chrono>
#include <condition_variable>
#include <functional>
#include <thread>

#include "tests/server/pipeline/robots.h"

namespace isthmus::server {
namespace {

// A flag that others wait for, but not forever: it may rightly not come.
class Flag {
 public:
  void Set() {
    std::lock_guard lock(mutex_);
    set_ = true;
    changed_.notify_all();
  }
  void Wait() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return set_; });
  }
  void WaitFor(std::chrono::milliseconds time) {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, time, [this] { return set_; });
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  bool set_ = false;  // Guarded by mutex_.
};

// Runs hooks where the pipeline writes or deletes, to bring about one order of events.
class HookedStore : public FullDisk {
 public:
  explicit HookedStore(std::shared_ptr<std::atomic<bool>> full)
      : FullDisk(storage::MakeMemoryStore(), std::move(full)) {}

  using BeforeWrite = std::function<void(const storage::WriteBatch&)>;

  // While the server writes, if need be: changes that could not be stored are tried again by
  // themselves.
  void SetBeforeWrite(BeforeWrite hook) {
    std::lock_guard lock(mutex_);
    before_write_ = std::move(hook);
  }
  std::function<void()> before_delete = [] {}, after_delete = [] {};

  absl::Status Write(const storage::WriteBatch& batch) override {
    BeforeWrite hook;
    {
      std::lock_guard lock(mutex_);
      hook = before_write_;
    }
    hook(batch);
    return FullDisk::Write(batch);
  }
  using FullDisk::DeleteSession;
  absl::Status DeleteSession(const SessionId& id, const std::vector<Event>& events) override {
    before_delete();
    const absl::Status status = FullDisk::DeleteSession(id, events);
    after_delete();
    return status;
  }

 private:
  std::mutex mutex_;
  BeforeWrite before_write_ = [](const auto&) {};  // Guarded by mutex_.
};

class PipelineConcurrency : public testing::Test {
 protected:
  const std::shared_ptr<std::atomic<bool>> full_ = std::make_shared<std::atomic<bool>>(false);
  HookedStore* store_ = new HookedStore(full_);
  const std::unique_ptr<Pipeline> pipeline_ =
      Pipeline::Open(QuickOptions(), std::unique_ptr<storage::MapStore>(store_)).value();
};

TEST_F(PipelineConcurrency, DeletingWaitsForASubmapThatIsBeingStored) {
  Drive drive;
  const SessionId session = Create(*pipeline_);
  *full_ = true;
  ASSERT_TRUE(drive.Submit(*pipeline_, session, 0, 10).ok());
  pipeline_->WaitUntilIdle();  // Two submaps wait for the disk.
  Flag storing, deleting, submitted;
  store_->SetBeforeWrite([&](const storage::WriteBatch& batch) {
    if (batch.submaps.empty()) return;
    storing.Set();
    deleting.WaitFor(std::chrono::milliseconds(100));  // Does not come: it waits for this.
  });
  store_->before_delete = [&] {
    deleting.Set();
    submitted.Wait();
  };
  *full_ = false;
  absl::Status sent;
  std::thread robot([&] {
    sent = pipeline_->sessions().SubmitScan(session, drive.Upload(10));
    submitted.Set();
  });
  storing.Wait();
  EXPECT_TRUE(pipeline_->sessions().Delete(session).ok());
  robot.join();
  EXPECT_EQ(sent.code(), absl::StatusCode::kUnavailable);
  EXPECT_TRUE(store_->ListSubmaps(std::nullopt)->empty());
  EXPECT_TRUE(pipeline_->reader().ListSubmaps(std::nullopt)->empty());
}

TEST_F(PipelineConcurrency, ASessionDeletedWhileItFinishesStaysDeleted) {
  const SessionId session = Create(*pipeline_);
  Flag finishing, deleted;
  store_->SetBeforeWrite([&](const storage::WriteBatch& batch) {
    if (batch.sessions.empty()) return;
    finishing.Set();
    deleted.WaitFor(std::chrono::milliseconds(100));  // Does not come: it waits for this.
  });
  store_->after_delete = [&] { deleted.Set(); };
  std::thread finisher([&] { (void)pipeline_->sessions().Finish(session); });
  finishing.Wait();
  EXPECT_TRUE(pipeline_->sessions().Delete(session).ok());
  finisher.join();
  EXPECT_TRUE(pipeline_->sessions().List().empty());
  EXPECT_TRUE(store_->ListSessions()->empty());
}

TEST_F(PipelineConcurrency, ADeletedSessionsNameIsNotGivenAgain) {
  const SessionId first = Create(*pipeline_);
  ASSERT_TRUE(pipeline_->sessions().Delete(first).ok());
  EXPECT_NE(Create(*pipeline_), first);
}

// Looks at everything until told to stop; every answer must be one that a reader can use.
void ReadEverything(Pipeline& pipeline, const std::atomic<bool>& stop) {
  int64_t newest = 0;
  while (!stop) {
    const MapInfo info = pipeline.GetMapInfo();
    EXPECT_GE(info.revision, newest);
    newest = info.revision;
    EXPECT_TRUE(pipeline.reader().ListSubmaps(std::nullopt).ok());
    for (const SessionStatus& status : pipeline.sessions().List()) {
      EXPECT_LE(status.durable_sequence, status.last_sequence);
      (void)pipeline.reader().GetTrajectory(status.record.robot, TrajectoryFrame::kMap);
    }
    (void)pipeline.reader().GetMatchGraph();
    size_t bytes = 0;
    const auto count = [&](const std::string& chunk) { return (bytes += chunk.size()) > 0; };
    int64_t revision = -1;
    const auto begin = [&revision](int64_t of) { revision = of; };
    EXPECT_TRUE(
        pipeline.reader().ExportMap({.format = ExportFormat::kPcdBinary}, begin, count).ok());
    EXPECT_GE(revision, 0);
    EXPECT_GT(bytes, 0u);
    // OctoMaps do not wait for the composed map, and say so.
    EXPECT_TRUE(
        pipeline.reader().ExportMap({.format = ExportFormat::kOctoMapBinary}, begin, count).ok());
    EXPECT_GE(revision, newest);
    EXPECT_LE(revision, pipeline.GetMapInfo().revision);
  }
}

TEST_F(PipelineConcurrency, RobotsComeAndGoWhileOthersReadTheMap) {
  constexpr int kRobots = 3, kScans = 7;
  Drive drive(kRobots);
  std::atomic<bool> stop = false;
  std::thread reader([&] { ReadEverything(*pipeline_, stop); });
  std::vector<std::thread> robots;
  for (int robot = 0; robot < kRobots; ++robot) {
    robots.emplace_back([&, robot] {
      const int rounds = robot == 0 ? 3 : 1;  // The first one's sessions are deleted.
      for (int round = 0; round < rounds; ++round) {
        AckLog log;
        const SessionId session =
            Create(*pipeline_, RobotId(std::string("robot") + char('a' + robot)));
        EXPECT_TRUE(pipeline_->sessions().SetAckSink(session, log.Sink()).ok());
        EXPECT_TRUE(drive.Submit(*pipeline_, session, 0, kScans, robot).ok());
        if (robot == 0) {
          EXPECT_TRUE(pipeline_->sessions().Delete(session).ok());
          continue;
        }
        EXPECT_EQ(pipeline_->sessions().Finish(session)->durable_sequence, uint64_t{kScans});
        EXPECT_EQ(log.TakeScans().size(), size_t{kScans});
        EXPECT_TRUE(pipeline_->sessions().SetAckSink(session, nullptr).ok());
      }
    });
  }
  for (std::thread& robot : robots) robot.join();
  pipeline_->WaitUntilIdle();
  stop = true;
  reader.join();
  EXPECT_EQ(pipeline_->sessions().List().size(), size_t{kRobots - 1});
  EXPECT_EQ(pipeline_->reader().ListSubmaps(std::nullopt)->size(), size_t{2 * (kRobots - 1)});
  EXPECT_TRUE(pipeline_->GetMapInfo().settled);
}

}  // namespace
}  // namespace isthmus::server
