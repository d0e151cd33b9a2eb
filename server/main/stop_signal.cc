#include "server/main/stop_signal.h"

namespace isthmus::server {

StopSignal::StopSignal() {
  sigemptyset(&signals_);
  sigaddset(&signals_, SIGTERM);
  sigaddset(&signals_, SIGINT);
  sigaddset(&signals_, SIGHUP);
  pthread_sigmask(SIG_BLOCK, &signals_, nullptr);
  signal(SIGPIPE, SIG_IGN);
}

std::string StopSignal::Wait(const std::function<void()>& on_hangup) {
  int received = 0;
  while (sigwait(&signals_, &received) != 0 || received == SIGHUP) {
    if (received == SIGHUP) on_hangup();
  }
  // Whatever the parent left: the next one takes its default course, in this thread.
  signal(SIGHUP, SIG_IGN);
  signal(SIGTERM, SIG_DFL);
  signal(SIGINT, SIG_DFL);
  pthread_sigmask(SIG_UNBLOCK, &signals_, nullptr);
  return received == SIGTERM ? "SIGTERM" : "SIGINT";
}

}  // namespace isthmus::server
