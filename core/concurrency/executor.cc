#include "core/concurrency/executor.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "core/caught.h"
#include "core/concurrency/thread_role.h"

namespace isthmus {

// Guarded by the executor's mutex; of one executor.
class Executor::Lane {
 public:
  struct Waiting {
    uint64_t number;
    std::shared_ptr<Lane> lane;  // Itself: a lane lives as long as it has tasks.
    std::function<void()> run;
  };
  double charge = 1;
  double due_s = 0;       // The virtual time at which its next task starts at the earliest.
  double expected_s = 0;  // Time of a task: the last one's, or what is left of a longer one before.
  int running = 0;
  bool is_listed = false;
  std::deque<Waiting> waiting;
};

std::shared_ptr<Executor::Lane> Executor::MakeLane(double charge) {
  auto lane = std::make_shared<Lane>();
  lane->charge = charge;
  return lane;
}

namespace {

double SteadySeconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

Executor::Options WithClock(Executor::Options options) {
  if (!options.now_s) options.now_s = SteadySeconds;
  return options;
}

// A longer task is forgotten by half with every shorter one.
constexpr double kForgotten = 0.5;

}  // namespace

Executor::Executor(const Options& options)
    : options_(WithClock(options)), common_(std::make_shared<Lane>()) {
  for (int i = 0; i < options_.threads; ++i) threads_.emplace_back([this] { Work(); });
}

Executor::~Executor() {
  {
    MutexLock lock(&mutex_);
    stopping_ = true;
  }
  wake_.SignalAll();
  for (std::thread& thread : threads_) thread.join();
}

void Executor::Post(std::function<void()> task) { Post(common_, std::move(task)); }

void Executor::Post(std::shared_ptr<Lane> lane, std::function<void()> task) {
  {
    MutexLock lock(&mutex_);
    lane->waiting.push_back({posted_++, lane, std::move(task)});
    ++queued_;
    Enqueue(lane.get());
  }
  wake_.Signal();
}

void Executor::Enqueue(Lane* lane) {
  if (lane->is_listed || lane->waiting.empty()) return;
  // The running task's time is to be charged before others are compared.
  if (lane->running > 0 && lane != common_.get()) return;
  lane->due_s = std::max(lane->due_s, virtual_s_);
  waiting_.insert({lane->due_s, lane->waiting.front().number, lane});
  lane->is_listed = true;
}

void Executor::SetCharge(Lane& lane, double charge) {
  MutexLock lock(&mutex_);
  lane.charge = charge;
}

void Executor::Charge(Lane* lane, double took_s) {
  lane->expected_s = std::max(took_s, kForgotten * lane->expected_s);
  // The common lane is a queue of first come, first served, not somebody's share.
  if (lane != common_.get()) lane->due_s += took_s * lane->charge;
}

bool Executor::IsSlow(const Lane& lane) const { return lane.expected_s > options_.slow_s; }

bool Executor::MayRunSlow() const {
  if (options_.threads < 2 || running_slow_ < options_.threads - 1) return true;
  return stopping_ || options_.now_s() - last_quick_s_ > options_.quick_memory_s;
}

bool Executor::Take(Task* task) {
  const bool may_run_slow = MayRunSlow();
  for (auto it = waiting_.begin(); it != waiting_.end(); ++it) {
    Lane* const lane = std::get<Lane*>(*it);
    if (!may_run_slow && IsSlow(*lane)) continue;
    virtual_s_ = std::max(virtual_s_, std::get<double>(*it));
    waiting_.erase(it);
    lane->is_listed = false;
    ++lane->running;
    task->lane = std::move(lane->waiting.front().lane);
    task->run = std::move(lane->waiting.front().run);
    lane->waiting.pop_front();
    --queued_;
    Enqueue(lane);
    return true;
  }
  return false;
}

absl::Status Executor::WaitUntilIdle() {
  MutexLock lock(&mutex_);
  while (queued_ > 0 || running_ > 0) idle_.Wait(&mutex_);
  return std::exchange(thrown_, absl::OkStatus());
}

void Executor::Work() {
  if (!options_.name.empty()) NameThread(options_.name);
  while (true) {
    Task task;
    bool is_slow = false;
    double begin_s = 0;
    {
      MutexLock lock(&mutex_);
      while (!Take(&task)) {
        if (stopping_ && queued_ == 0) return;
        wake_.Wait(&mutex_);
      }
      begin_s = options_.now_s();
      is_slow = IsSlow(*task.lane);
      ++running_;
      running_slow_ += is_slow ? 1 : 0;
      if (!is_slow) last_quick_s_ = begin_s;
    }
    absl::Status thrown;
    try {
      task.run();
    } catch (...) {
      thrown = CaughtStatus();
    }
    task.run = nullptr;  // Destroy captures outside the lock.
    MutexLock lock(&mutex_);
    Lane& lane = *task.lane;
    Charge(&lane, std::max(options_.now_s() - begin_s, 0.0));
    --lane.running;
    Enqueue(&lane);
    thrown_.Update(std::move(thrown));
    --running_;
    running_slow_ -= is_slow ? 1 : 0;
    // A slow task may have been waiting for this one to end.
    if (!waiting_.empty()) wake_.Signal();
    if (queued_ == 0 && running_ == 0) idle_.SignalAll();
    if (stopping_ && queued_ == 0) wake_.SignalAll();
  }
}

}  // namespace isthmus
