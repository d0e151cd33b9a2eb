// The calls of tokens that are under way, so that they end when their token does.
#pragma once

#include <absl/status/status.h>

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <thread>

#include "core/concurrency/mutex.h"

namespace isthmus::rpc {

// The state that the gate shares with a call that it let in: the call may go on, or must end.
// Thread safe.
class Admission {
 public:
  using OnEnd = std::function<void(const absl::Status&)>;

  // Ok, or why the call must end: its token was revoked, or has expired.
  absl::Status status() const;
  // The callback is called once, from a thread of the gate, when the call must end; at once, from
  // this thread, where that has happened already. It must not block.
  void SetOnEnd(OnEnd on_end);
  // No callback runs after this, nor while it returns, but where the callback itself calls it.
  void Forget();
  void End(const absl::Status& status);

 private:
  mutable Mutex mutex_;
  CondVar told_;
  absl::Status status_ ABSL_GUARDED_BY(mutex_);
  OnEnd on_end_ ABSL_GUARDED_BY(mutex_);
  std::thread::id telling_ ABSL_GUARDED_BY(mutex_);  // None: nobody is being told.
};

// Thread safe.
class RunningCalls {
 public:
  // `cancel`, which may be null, is not called once the call has left.
  void Enter(const std::shared_ptr<Admission>& call, const std::string& token,
             std::function<void()> cancel);
  void Leave(const std::shared_ptr<Admission>& call);

  // Ends the calls of tokens for which `holds` has another answer than ok. A call that goes on
  // regardless is cancelled a few reviews later.
  void Review(const std::function<absl::Status(const std::string& token)>& holds);

 private:
  struct Running {
    std::string token;
    std::function<void()> cancel;
    int reviews_over = 0;  // Since it was told to end.
  };

  Mutex mutex_;
  std::map<std::shared_ptr<Admission>, Running> calls_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace isthmus::rpc
