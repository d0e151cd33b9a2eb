#include "fleet/postgresql/object_sweeper.h"

#include <absl/strings/str_cat.h>

#include <chrono>
#include <utility>

#include "fleet/objects/limits.h"

namespace isthmus::storage {

ObjectSweeper::ObjectSweeper(LargeValues& values, RunOnConnection read, RunOnConnection write,
                             std::function<void(const std::string&)> on_problem)
    : values_(values),
      read_(std::move(read)),
      write_(std::move(write)),
      on_problem_(std::move(on_problem)),
      thread_([this] { Loop(); }) {}

ObjectSweeper::~ObjectSweeper() {
  {
    MutexLock lock(&mutex_);
    is_ending_ = true;
    changed_.Signal();
  }
  thread_.join();
}

bool ObjectSweeper::Rest(absl::Duration duration) {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point until = Clock::now() + absl::ToChronoSeconds(duration);
  MutexLock lock(&mutex_);
  while (!is_ending_ && Clock::now() < until) changed_.WaitFor(&mutex_, until - Clock::now());
  return !is_ending_;
}

void ObjectSweeper::Loop() {
  std::string told;
  absl::Duration rest = kFirstSweep;
  while (Rest(rest)) {
    rest = kSweepEvery;
    const absl::Status status = SweepObjects(values_, read_, write_, kUnreferencedStay).status();
    const std::string problem(status.message());
    if (!status.ok() && problem != told && on_problem_) {
      on_problem_(
          absl::StrCat("objects of the bucket to which nothing refers stay for now: ", problem));
    }
    told = problem;
  }
}

}  // namespace isthmus::storage
