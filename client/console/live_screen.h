// A terminal's screen that is drawn again and again, and is as before at the end.
#pragma once

#include <termios.h>

#include <chrono>
#include <cstddef>
#include <string>
#include <vector>

#include "core/concurrency/mutex.h"

namespace isthmus::cli {

// Takes the terminal's other screen, so that what was on it comes back, and its keys one by one.
// Thread safe.
class LiveScreen {
 public:
  // True if there is a terminal to draw on and to hear keys from.
  static bool IsPossible();

  LiveScreen();
  ~LiveScreen();  // Leaves.
  LiveScreen(const LiveScreen&) = delete;
  LiveScreen& operator=(const LiveScreen&) = delete;

  // As the terminal is now.
  static size_t columns();
  // Lines that do not fit below are left out, and the screen says so.
  void Draw(std::vector<std::string> lines);
  // The next key, 0 if none comes in that time or the terminal is gone ("q" then).
  char WaitForKey(std::chrono::milliseconds longest);
  // From now on nothing is drawn: the terminal is as it was.
  void Leave();

 private:
  Mutex mutex_;
  bool is_left_ ABSL_GUARDED_BY(mutex_) = false;
  termios before_ = {};
  bool has_before_ = false;
};

}  // namespace isthmus::cli
