// isthmus top: how the server is getting on, once a second.
#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <limits>
#include <memory>
#include <string>
#include <utility>

#include "client/console/command.h"
#include "client/console/exit_code.h"
#include "client/console/interruption.h"
#include "client/console/live_screen.h"
#include "client/console/numbers.h"
#include "client/console/top_frame.h"

namespace isthmus::cli {
namespace {

// A server that has not answered by then is said to be out of reach: a person waits for a frame.
constexpr double kAnswerTimeoutS = 3;

struct TopOptions {
  ServerOptions server;
  double interval_s = 1;
  uint64_t frames = 0;  // 0: until it is stopped.
  bool batch = false;
};

// True if asking again may help.
bool IsAway(const absl::Status& status) {
  // Cancelled: the server ended while it answered.
  return absl::IsUnavailable(status) || absl::IsDeadlineExceeded(status) ||
         absl::IsResourceExhausted(status) || absl::IsCancelled(status);
}

// Asks, and notes the answer; an error where asking again is no help.
absl::Status Update(client::Client& client, TopView* view) {
  absl::StatusOr<ServerStatus> status = client.GetStatus();
  if (status.ok()) {
    view->before = std::exchange(view->status, *std::move(status));
    view->problem.clear();
    return absl::OkStatus();
  }
  if (absl::IsUnimplemented(status.status())) {
    return absl::UnimplementedError("this server is too old to be watched; use `isthmus status`");
  }
  if (!IsAway(status.status())) return status.status();
  view->problem = std::string(status.status().message());
  return absl::OkStatus();
}

// Waits until then; false once it was interrupted.
bool WaitUntil(std::chrono::steady_clock::time_point then, const Interruption& interruption,
               int interrupted) {
  const auto left =
      std::chrono::ceil<std::chrono::milliseconds>(then - std::chrono::steady_clock::now());
  pollfd event = {interrupted, POLLIN, 0};
  ::poll(&event, 1, static_cast<int>(std::max<int64_t>(0, left.count())));
  return !interruption.happened();
}

int PrintFrames(client::Client& client, const TopOptions& options, const Interruption& interruption,
                int interrupted) {
  TopView view{options.server.address, {}, {}, {}};
  const auto interval = std::chrono::duration<double>(options.interval_s);
  for (uint64_t frame = 1;; ++frame) {
    const auto next = std::chrono::steady_clock::now() +
                      std::chrono::duration_cast<std::chrono::nanoseconds>(interval);
    if (absl::Status status = Update(client, &view); !status.ok()) return FailServer(status);
    if (interruption.happened()) return kInterrupted;
    if (frame > 1) std::puts("");
    for (const std::string& line : TopLines(view, std::numeric_limits<size_t>::max())) {
      std::puts(line.c_str());
    }
    std::fflush(stdout);
    if (frame == options.frames) return view.problem.empty() ? kOk : kNotReachable;
    if (!WaitUntil(next, interruption, interrupted)) return kInterrupted;
  }
}

// Until somebody presses q.
int ShowFrames(client::Client& client, const TopOptions& options, const Interruption& interruption,
               LiveScreen* screen) {
  TopView view{options.server.address, {}, {}, {}};
  const auto interval = std::chrono::duration_cast<std::chrono::milliseconds>(
      std::chrono::duration<double>(options.interval_s));
  while (!interruption.happened()) {
    const auto next = std::chrono::steady_clock::now() + interval;
    if (absl::Status status = Update(client, &view); !status.ok()) {
      screen->Leave();
      return FailServer(status);
    }
    screen->Draw(TopLines(view, LiveScreen::columns()));
    for (auto left = interval; left.count() > 0 && !interruption.happened();
         left = std::chrono::ceil<std::chrono::milliseconds>(next -
                                                             std::chrono::steady_clock::now())) {
      // In steps, as Ctrl-C wakes nobody who waits for a key.
      const char key = screen->WaitForKey(std::min(left, std::chrono::milliseconds(100)));
      if (key == 'q' || key == 'Q') return kOk;
    }
  }
  return kInterrupted;
}

int Run(const TopOptions& options) {
  absl::StatusOr<client::ClientOptions> asked = ClientOptionsOf(options.server);
  if (!asked.ok()) return Fail(kUsage, asked.status());
  asked->call_timeout_s = kAnswerTimeoutS;
  asked->backoff.max_attempts = 1;  // The next frame is the next attempt.
  const bool live = !options.batch && options.frames == 0 && LiveScreen::IsPossible();
  const int interrupted = ::eventfd(0, EFD_CLOEXEC);
  std::unique_ptr<LiveScreen> screen;
  // Before the client's threads, and before the screen is taken: Ctrl-C gives it back at once, also
  // while an answer is waited for.
  std::atomic<LiveScreen*> shown = nullptr;
  const Interruption interruption([&] {
    if (LiveScreen* const taken = shown) taken->Leave();
    const uint64_t one = 1;
    (void)!::write(interrupted, &one, sizeof(one));
  });
  const auto client = client::Client::Connect(*asked);
  if (!client.ok()) return FailServer(client.status());
  if (!live) return PrintFrames(**client, options, interruption, interrupted);
  screen = std::make_unique<LiveScreen>();
  shown = screen.get();
  return ShowFrames(**client, options, interruption, screen.get());
}

}  // namespace

void AddTop(CLI::App& app, Action& action) {
  auto options = std::make_shared<TopOptions>();
  CLI::App* command =
      app.add_subcommand("top", "The server's state, once a second: robots, queues, disk; q quits");
  AddServerOptions(*command, options->server);
  command->add_option("-d,--interval", options->interval_s, "Seconds between frames")
      ->check(Between(0.1, 3600.0))
      ->capture_default_str();
  command->add_option("-n,--frames", options->frames, "Print this many frames one by one, then end")
      ->check(CLI::Range(1, 1'000'000));
  command->add_flag("--batch", options->batch,
                    "Print frames one by one, as when the output is not a terminal");
  command->callback([options, &action] { action = [options] { return Run(*options); }; });
}

}  // namespace isthmus::cli
