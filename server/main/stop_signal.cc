#include "server/main/stop_signal.h"

namespace isthmus::server {

StopSignal::StopSignal() {
  sigemptyset(&signals_);
  sigaddset(&signals_, SIGTERM);
  sigaddset(&signals_, SIGINT);
  pthread_sigmask(SIG_BLOCK, &signals_, nullptr);
  signal(SIGPIPE, SIG_IGN);
}

std::string StopSignal::Wait() {
  int received = 0;
  while (sigwait(&signals_, &received) != 0) {
  }
  // Whatever the parent left: the next one takes its default course, in this thread.
  signal(SIGTERM, SIG_DFL);
  signal(SIGINT, SIG_DFL);
  pthread_sigmask(SIG_UNBLOCK, &signals_, nullptr);
  return received == SIGTERM ? "SIGTERM" : "SIGINT";
}

}  // namespace isthmus::server
