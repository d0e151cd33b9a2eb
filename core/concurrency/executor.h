// A fixed number of threads that run tasks, sharing their time fairly among those who post.
#pragma once

#include <absl/status/status.h>

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <thread>
#include <tuple>
#include <vector>

#include "core/concurrency/mutex.h"

namespace isthmus {

// Thread safe. The destructor runs what was posted, then joins.
//
// Tasks are posted to lanes, one for each who is to be treated fairly. The waiting task of the lane
// that was served least comes first (start-time fair queueing: P. Goyal, H. M. Vin, H. Cheng,
// "Start-time Fair Queuing", SIGCOMM 1996): a lane that used less than its share so far waits for
// the tasks at hand only, however many others wait, and one that was idle has saved up nothing.
// Within a lane tasks run one at a time, in the order of posting. Lanes whose tasks take long never
// occupy the last thread while others are about.
class Executor {
 public:
  // A poster of tasks. Kept alive by its tasks.
  class Lane;
  // The time that a lane's tasks take counts `charge` times: above 1 for what can wait.
  static std::shared_ptr<Lane> MakeLane(double charge = 1);

  struct Options {
    int threads = 1;
    // A task of a lane whose tasks take longer than this, seconds, is slow: such leave one thread
    // (of two or more) to others that were at work within the last `quick_memory_s`.
    double slow_s = 0.1, quick_memory_s = 1;
    std::string name = {};                    // The threads' name, 15 characters at most.
    std::function<double()> now_s = nullptr;  // For tests; null: the steady clock.
  };
  explicit Executor(int threads) : Executor(Options{.threads = threads}) {}
  explicit Executor(const Options& options);
  ~Executor();
  Executor(const Executor&) = delete;
  Executor& operator=(const Executor&) = delete;

  // Runs `task` on some thread. An exception ends its task alone. Callers bound what they post; the
  // executor itself does not refuse. Without a lane: to one that all such share, whose tasks run
  // side by side, in order of posting.
  void Post(std::function<void()> task);
  void Post(std::shared_ptr<Lane> lane, std::function<void()> task);
  // From now on.
  void SetCharge(Lane& lane, double charge);

  // Waits until nothing is queued and nothing runs. Must not be called from a task. Fails with what
  // the first task threw since the last call (CaughtStatus), if one did.
  absl::Status WaitUntilIdle();

 private:
  struct Task {
    std::shared_ptr<Lane> lane;
    std::function<void()> run;
  };
  // The next lane first: by its time, then by the order of posting.
  using Place = std::tuple<double, uint64_t, Lane*>;

  void Work();
  // The task to run now, if there is one that may.
  bool Take(Task* task) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  bool IsSlow(const Lane& lane) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  bool MayRunSlow() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Enqueue(Lane* lane) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Adds to what the lane has used.
  void Charge(Lane* lane, double took_s) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const Options options_;
  const std::shared_ptr<Lane> common_;
  mutable Mutex mutex_;
  CondVar wake_, idle_;
  std::set<Place> waiting_ ABSL_GUARDED_BY(mutex_);  // One for each lane that has tasks to start.
  double virtual_s_ ABSL_GUARDED_BY(mutex_) = 0;     // Virtual time of the task started last.
  uint64_t posted_ ABSL_GUARDED_BY(mutex_) = 0;
  uint64_t queued_ ABSL_GUARDED_BY(mutex_) = 0;
  int running_ ABSL_GUARDED_BY(mutex_) = 0;
  int running_slow_ ABSL_GUARDED_BY(mutex_) = 0;
  double last_quick_s_ ABSL_GUARDED_BY(mutex_) = -1e9;
  absl::Status thrown_ ABSL_GUARDED_BY(mutex_);  // By the first since WaitUntilIdle.
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  std::vector<std::thread> threads_;  // Constant after construction.
};

}  // namespace isthmus
