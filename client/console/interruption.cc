#include "client/console/interruption.h"

#include <pthread.h>
#include <signal.h>
#include <unistd.h>

#include <chrono>
#include <utility>

#include "client/console/exit_code.h"

namespace isthmus::cli {
namespace {

sigset_t EndingSignals() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGINT);
  sigaddset(&set, SIGTERM);
  return set;
}

}  // namespace

Interruption::Interruption(std::function<void()> on_interrupt)
    : on_interrupt_(std::move(on_interrupt)) {
  const sigset_t set = EndingSignals();
  pthread_sigmask(SIG_BLOCK, &set, nullptr);
  thread_ = std::thread([this] { Watch(); });
}

Interruption::~Interruption() {
  ending_ = true;
  pthread_kill(thread_.native_handle(), SIGTERM);
  thread_.join();
  const sigset_t set = EndingSignals();
  pthread_sigmask(SIG_UNBLOCK, &set, nullptr);
}

void Interruption::Watch() {
  // Nobody presses Ctrl-C twice in that time.
  constexpr std::chrono::milliseconds kOneWish(300);
  std::chrono::steady_clock::time_point first;
  const sigset_t set = EndingSignals();
  for (;;) {
    int signal = 0;
    if (sigwait(&set, &signal) != 0) continue;
    if (ending_) return;
    const auto now = std::chrono::steady_clock::now();
    if (happened_.exchange(true)) {
      // Some send it to the process and to its group: that is one wish, not two.
      if (now - first < kOneWish) continue;
      // Destructors would wait for what the user no longer waits for.
      _exit(kInterrupted);
    }
    first = now;
    on_interrupt_();
  }
}

}  // namespace isthmus::cli
