#include "client/console/live_screen.h"

#include <absl/strings/str_cat.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <string_view>

namespace isthmus::cli {
namespace {

// As xterm has them, and every terminal since.
constexpr char kEnter[] = "\x1b[?1049h\x1b[?25l", kLeave[] = "\x1b[?25h\x1b[?1049l";
constexpr char kHome[] = "\x1b[H", kRestOfLine[] = "\x1b[K", kRestOfScreen[] = "\x1b[J";

winsize SizeOfTerminal() {
  winsize size = {};
  if (::ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) != 0) size = {};
  if (size.ws_col == 0) size.ws_col = 80;
  if (size.ws_row == 0) size.ws_row = 24;
  return size;
}

void WriteAll(std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::write(STDOUT_FILENO, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return;  // It is gone, which the next key says.
    text.remove_prefix(static_cast<size_t>(written));
  }
}

}  // namespace

bool LiveScreen::IsPossible() {
  const char* kind = std::getenv("TERM");
  return ::isatty(STDOUT_FILENO) == 1 && ::isatty(STDIN_FILENO) == 1 && kind != nullptr &&
         std::string_view(kind) != "dumb";
}

LiveScreen::LiveScreen() {
  has_before_ = ::tcgetattr(STDIN_FILENO, &before_) == 0;
  if (has_before_) {
    termios keys = before_;
    keys.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
    keys.c_cc[VMIN] = 0;
    keys.c_cc[VTIME] = 0;
    // Stopped by Ctrl-Z it would leave the shell on this screen.
    keys.c_cc[VSUSP] = _POSIX_VDISABLE;
    ::tcsetattr(STDIN_FILENO, TCSANOW, &keys);
  }
  WriteAll(kEnter);
}

LiveScreen::~LiveScreen() { Leave(); }

size_t LiveScreen::columns() { return SizeOfTerminal().ws_col; }

void LiveScreen::Draw(std::vector<std::string> lines) {
  const size_t rows = SizeOfTerminal().ws_row;
  if (lines.size() > rows) {
    const size_t hidden = lines.size() - rows + 1;
    lines.resize(rows - 1);
    lines.push_back(absl::StrCat("and ", hidden, " more lines"));
  }
  std::string frame = kHome;
  for (size_t i = 0; i < lines.size(); ++i) {
    absl::StrAppend(&frame, i == 0 ? "" : "\r\n", lines[i], kRestOfLine);
  }
  frame += kRestOfScreen;
  MutexLock lock(&mutex_);
  if (!is_left_) WriteAll(frame);
}

char LiveScreen::WaitForKey(std::chrono::milliseconds longest) {
  pollfd keys = {STDIN_FILENO, POLLIN, 0};
  if (::poll(&keys, 1, static_cast<int>(longest.count())) <= 0) return 0;
  char key = 0;
  const ssize_t count = ::read(STDIN_FILENO, &key, 1);
  return count == 1 ? key : 'q';
}

void LiveScreen::Leave() {
  MutexLock lock(&mutex_);
  if (is_left_) return;
  is_left_ = true;
  WriteAll(kLeave);
  if (has_before_) ::tcsetattr(STDIN_FILENO, TCSANOW, &before_);
}

}  // namespace isthmus::cli
