#include "client/console/say.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_split.h>

#include "core/plain_text.h"

namespace isthmus::cli {

std::string Printable(absl::string_view text) { return LineOf(text, text.npos); }

std::string Lines(absl::string_view text, size_t longest_line) {
  std::string out;
  bool is_first = true;
  for (const absl::string_view line : absl::StrSplit(text, '\n')) {
    absl::StrAppend(&out, std::exchange(is_first, false) ? "" : "\n", LineOf(line, longest_line));
  }
  return out;
}

void SayLines(absl::string_view text) { std::fputs(Lines(text).c_str(), stdout); }

}  // namespace isthmus::cli
