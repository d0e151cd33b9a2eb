#include "server/main/stop_signal.h"

namespace isthmus::server {

namespace {

std::string NameOf(int signal) { return signal == SIGTERM ? "SIGTERM" : "SIGINT"; }

}  // namespace

StopSignal::StopSignal() {
  sigemptyset(&signals_);
  sigaddset(&signals_, SIGTERM);
  sigaddset(&signals_, SIGINT);
  sigaddset(&signals_, SIGHUP);
  pthread_sigmask(SIG_BLOCK, &signals_, nullptr);
  signal(SIGPIPE, SIG_IGN);
}

void StopSignal::Unblock() { pthread_sigmask(SIG_UNBLOCK, &signals_, nullptr); }

std::string StopSignal::Wait(const std::function<void()>& on_hangup) {
  int received = 0;
  while (sigwait(&signals_, &received) != 0 || received == SIGHUP) {
    if (received == SIGHUP) on_hangup();
  }
  // The next signal takes its default course, in this thread, whatever the parent left.
  signal(SIGHUP, SIG_IGN);
  signal(SIGTERM, SIG_DFL);
  signal(SIGINT, SIG_DFL);
  Unblock();
  return NameOf(received);
}

std::optional<std::string> StopSignal::WaitFor(std::chrono::milliseconds longest,
                                               const std::function<void()>& on_hangup) {
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(longest);
  const std::chrono::nanoseconds rest = longest - seconds;
  const timespec timeout = {seconds.count(), rest.count()};
  const int received = sigtimedwait(&signals_, nullptr, &timeout);
  if (received == SIGHUP) on_hangup();
  if (received != SIGTERM && received != SIGINT) return std::nullopt;
  return NameOf(received);
}

}  // namespace isthmus::server
