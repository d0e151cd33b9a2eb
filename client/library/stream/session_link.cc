#include "client/library/stream/session_link.h"

#include <absl/strings/match.h>
#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/string_view.h>

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
constexpr char kTooLarge[] = "a message is larger than the server takes: ";

// At 1 MHz for ten thousand years.
constexpr uint64_t kMostScans = uint64_t{1} << 58;

}  // namespace

absl::Status CheckSession(const v1::Session& session) {
  const uint64_t scans = std::max(session.last_sequence(), session.durable_sequence());
  if (scans <= kMostScans) return absl::OkStatus();
  return absl::DataLossError(
      absl::StrCat("the server says that the session has ", scans,
                   " scans, which none has: is this isthmus-server, and its data sound?"));
}

std::optional<double> AskedToWait(const absl::Status& status) {
  const auto after = convert::RetryAfter(status);
  if (!after || !absl::IsResourceExhausted(status)) return std::nullopt;
  constexpr double kLongest = 60;  // At most, for any server.
  return std::clamp(std::chrono::duration<double>(*after).count(), 0.0, kLongest);
}

std::optional<uint64_t> LargestMessage(const absl::Status& status) {
  if (!absl::IsResourceExhausted(status)) return std::nullopt;
  // gRPC's own words, the same in all its versions: there is no other way to learn of it.
  constexpr absl::string_view kWords = "larger than max (", kBetween = " vs. ";
  const absl::string_view text = status.message();
  const size_t at = text.find(kWords);
  if (at == absl::string_view::npos) return std::nullopt;
  const size_t from = text.find(kBetween, at);
  const size_t to = text.find(')', at);
  uint64_t most = 0;
  if (from == absl::string_view::npos || to == absl::string_view::npos || to < from ||
      !absl::SimpleAtoi(text.substr(from + kBetween.size(), to - from - kBetween.size()), &most)) {
    return std::nullopt;
  }
  return most;
}

absl::Status SessionLink::Repeat(bool also_data_loss,
                                 const std::function<absl::Status()>& attempt) {
  Backoff backoff(options_.backoff, ways());
  for (;;) {
    const absl::Status status = attempt();
    const std::optional<double> asked_s = AskedToWait(status);
    const bool again =
        absl::IsUnavailable(status) || asked_s || (also_data_loss && absl::IsDataLoss(status));
    if (!again) return Explain(status);
    const std::optional<double> delay = backoff.Next();
    if (!delay) return Explain(status);
    Sleep(*delay + asked_s.value_or(0));
  }
}

absl::Status SessionLink::Explain(const absl::Status& status) const {
  if (LargestMessage(status) && !absl::StartsWith(status.message(), kTooLarge)) {
    return absl::ResourceExhaustedError(
        absl::StrCat(kTooLarge, status.message(),
                     ". Raise network.max_receive_bytes there, send fewer points or "
                     "fields, or have coordinates rounded (resolution)"));
  }
  const bool is_served = convert::RetryAfter(status).has_value();  // It answers, if not with that.
  if (!absl::IsUnavailable(status) || is_served || absl::StartsWith(status.message(), kSought)) {
    return status;
  }
  return absl::UnavailableError(absl::StrCat(
      kSought, options_.address, ": ", AdviceOnUnreachable(options_, std::string(status.message())),
      " (", status.message(), ")"));
}

void SessionLink::Sleep(double seconds) const {
  if (options_.sleep) return options_.sleep(seconds);
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}

}  // namespace isthmus::client
