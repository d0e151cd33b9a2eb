#include "client/readers/messages/clock_step.h"

#include <absl/strings/str_format.h>

#include <algorithm>

#include "client/readers/messages/limits.h"

namespace isthmus::readers {
namespace {

// Times may be any: differences are taken as numbers that do not overflow.
double Seconds(int64_t from_ns, int64_t to_ns) {
  return 1e-9 * (static_cast<double>(to_ns) - static_cast<double>(from_ns));
}

int64_t FirstOf(const std::vector<LogSpan>& spans, size_t begin, size_t end) {
  int64_t first_ns = spans[begin].first_ns;
  for (size_t i = begin; i < end; ++i) first_ns = std::min(first_ns, spans[i].first_ns);
  return first_ns;
}

int64_t LastOf(const std::vector<LogSpan>& spans, size_t begin, size_t end) {
  int64_t last_ns = spans[begin].last_ns;
  for (size_t i = begin; i < end; ++i) last_ns = std::max(last_ns, spans[i].last_ns);
  return last_ns;
}

// The only step, without what it means.
std::optional<ClockStep> OnlyStep(const std::vector<LogSpan>& spans) {
  ClockStep step;
  int64_t high_ns = spans[0].last_ns, before_ns = 0;
  for (size_t i = 1; i < spans.size(); ++i) {
    const LogSpan& span = spans[i];
    if (!GoesBack(high_ns, span.first_ns)) {
      high_ns = std::max(high_ns, span.last_ns);
      continue;
    }
    if (step.at == 0) {
      step.at = i;
      before_ns = high_ns;
    } else if (i == step.at + 1 && !GoesBack(before_ns, spans[step.at].last_ns)) {
      step.is_within = true;
    } else {
      return std::nullopt;
    }
    high_ns = span.last_ns;
  }
  // Alone, the last stretch may be an odd message, or hold those of both sides.
  const LogSpan& behind = spans[step.at];
  const bool is_clear = step.at + 1 < spans.size() ||
                        (behind.first_ns < behind.last_ns && GoesBack(before_ns, behind.last_ns));
  return step.at > 0 && is_clear ? std::optional(step) : std::nullopt;
}

}  // namespace

bool GoesBack(int64_t from_ns, int64_t to_ns) { return Seconds(to_ns, from_ns) > kLeastStepBackS; }

std::string ClockStep::Text() const {
  return absl::StrFormat(
      "the times of recording go back by %.1f s in the file: %s", back_s,
      was_set ? "the recorder's clock was probably set, and messages come in the order of "
                "the file"
              : "its parts are taken to be in the wrong order, and messages come by these times");
}

std::optional<ClockStep> FindClockStep(const std::vector<LogSpan>& spans) {
  if (spans.empty()) return std::nullopt;
  std::optional<ClockStep> step = OnlyStep(spans);
  if (!step) return std::nullopt;
  const size_t behind = step->at + (step->is_within ? 1 : 0), end = spans.size();
  const int64_t first_ns = FirstOf(spans, 0, step->at);
  const int64_t first_behind_ns = FirstOf(spans, step->at, end);
  if (first_behind_ns == first_ns) return std::nullopt;
  step->back_s = Seconds(first_behind_ns, LastOf(spans, 0, behind));
  const double between_s = Seconds(LastOf(spans, behind, end), first_ns);
  step->was_set = between_s < 0 || between_s > kMostJoinedS;
  return step;
}

}  // namespace isthmus::readers
