#include "server/rpc/running_calls.h"

#include <utility>
#include <vector>

namespace isthmus::rpc {
namespace {

// A call that waits in gRPC for its client does not hear that it must end. What does hear it ends
// within a moment, with a status that says why; cancelled, the client learns only that it is over.
constexpr int kReviewsUntilCancelled = 3;

}  // namespace

absl::Status Admission::status() const {
  MutexLock lock(&mutex_);
  return status_;
}

void Admission::SetOnEnd(OnEnd on_end) {
  absl::Status ended;
  {
    MutexLock lock(&mutex_);
    if (status_.ok()) {
      on_end_ = std::move(on_end);
      return;
    }
    ended = status_;
  }
  on_end(ended);
}

void Admission::Forget() {
  MutexLock lock(&mutex_);
  on_end_ = nullptr;
  // A callback that ends its own call would wait for itself.
  while (telling_ != std::thread::id() && telling_ != std::this_thread::get_id()) {
    told_.Wait(&mutex_);
  }
}

void Admission::End(const absl::Status& status) {
  OnEnd on_end;
  {
    MutexLock lock(&mutex_);
    if (!status_.ok()) return;
    status_ = status;
    on_end = std::exchange(on_end_, nullptr);
    if (on_end == nullptr) return;
    telling_ = std::this_thread::get_id();
  }
  on_end(status);
  MutexLock lock(&mutex_);
  telling_ = std::thread::id();
  told_.SignalAll();
}

void RunningCalls::Enter(const std::shared_ptr<Admission>& call, const std::string& token,
                         std::function<void()> cancel) {
  MutexLock lock(&mutex_);
  calls_[call] = {token, std::move(cancel)};
}

void RunningCalls::Leave(const std::shared_ptr<Admission>& call) {
  MutexLock lock(&mutex_);
  calls_.erase(call);
}

void RunningCalls::Review(const std::function<absl::Status(const std::string& token)>& holds) {
  std::vector<std::pair<std::shared_ptr<Admission>, absl::Status>> over;
  {
    MutexLock lock(&mutex_);
    std::map<std::string, absl::Status> answers;
    for (auto& [call, running] : calls_) {
      const auto [answer, is_new] = answers.try_emplace(running.token);
      if (is_new) answer->second = holds(running.token);
      if (answer->second.ok()) continue;
      if (running.reviews_over == 0) over.emplace_back(call, answer->second);
      // Here, where the call cannot leave: what is cancelled goes with it.
      if (++running.reviews_over > kReviewsUntilCancelled && running.cancel) running.cancel();
    }
  }
  for (const auto& [call, status] : over) call->End(status);
}

}  // namespace isthmus::rpc
