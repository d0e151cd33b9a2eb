#include "client/library/stream/session_link.h"

#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>

#include <algorithm>
#include <chrono>
#include <optional>
#include <thread>

#include "api/convert/retry_after.h"
#include "client/library/stream/backoff.h"
#include "client/library/stream/unreachable.h"

namespace isthmus::client {
namespace {

constexpr char kSought[] = "cannot reach isthmus-server at ";

}  // namespace

std::optional<double> AskedToWait(const absl::Status& status) {
  const auto after = convert::RetryAfter(status);
  if (!after || !absl::IsResourceExhausted(status)) return std::nullopt;
  constexpr double kLongest = 60;  // Whatever a server says.
  return std::clamp(std::chrono::duration<double>(*after).count(), 0.0, kLongest);
}

absl::Status SessionLink::Repeat(bool also_data_loss,
                                 const std::function<absl::Status()>& attempt) {
  Backoff backoff(options_.backoff);
  for (;;) {
    const absl::Status status = attempt();
    const std::optional<double> asked_s = AskedToWait(status);
    const bool again =
        absl::IsUnavailable(status) || asked_s || (also_data_loss && absl::IsDataLoss(status));
    if (!again) return status;
    const std::optional<double> delay = backoff.Next();
    if (!delay) return Explain(status);
    Sleep(*delay + asked_s.value_or(0));
  }
}

absl::Status SessionLink::Explain(const absl::Status& status) const {
  if (!absl::IsUnavailable(status) || absl::StartsWith(status.message(), kSought)) return status;
  return absl::UnavailableError(absl::StrCat(
      kSought, options_.address, ": ", AdviceOnUnreachable(options_, std::string(status.message())),
      " (", status.message(), ")"));
}

void SessionLink::Sleep(double seconds) const {
  if (options_.sleep) return options_.sleep(seconds);
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}

}  // namespace isthmus::client
