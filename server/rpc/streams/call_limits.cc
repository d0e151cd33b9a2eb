#include "server/rpc/streams/call_limits.h"

#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>

#include <algorithm>
#include <limits>

#include "api/convert/retry_after.h"

namespace isthmus::rpc {
namespace {

using Kind = access::CallKind;

const char* NameOf(Kind kind) {
  switch (kind) {
    case Kind::kStream:
      return "streams";
    case Kind::kQuery:
      return "queries";
    case Kind::kExport:
      return "exports";
    default:
      return "lists";
  }
}

}  // namespace

CallLimits::Ticket::~Ticket() {
  if (limits_ != nullptr) limits_->Leave(*this);
}

CallLimits::Most CallLimits::MostOf(Kind kind) const {
  const auto half = [](size_t all) {
    all = std::max<size_t>(1, all);
    return Most{all, std::max<size_t>(1, all / 2)};
  };
  switch (kind) {
    case Kind::kStream:
      return {options_.streams, options_.streams_per_caller};
    case Kind::kQuery:
    case Kind::kList:
      return half(options_.queries);
    case Kind::kExport:
      return half(options_.queries / kQueriesPerExport);
    default:
      return {std::numeric_limits<size_t>::max(), std::numeric_limits<size_t>::max()};
  }
}

absl::StatusOr<CallLimits::Ticket> CallLimits::Enter(Kind kind, const std::string& caller) {
  const Most most = MostOf(kind);
  const char* const name = NameOf(kind);
  const char* const setting = kind == Kind::kStream ? "max_streams" : "max_queries";
  MutexLock lock(&mutex_);
  if (stopped_) return absl::UnavailableError("the server is shutting down; try again");
  if (calls_[kind] >= most.in_all) {
    return convert::WithRetryAfter(
        absl::ResourceExhaustedError(absl::StrCat(
            "the server has ", most.in_all, " ", name,
            " under way, as many as it takes: try again in a moment, or raise network.", setting)),
        kRetryAfter);
  }
  const auto key = std::make_pair(kind, kind == Kind::kOther ? std::string() : caller);
  if (callers_[key] >= most.of_caller) {
    return convert::WithRetryAfter(
        absl::ResourceExhaustedError(absl::StrCat(
            "you have ", most.of_caller, " ", name,
            " under way, as many as one caller may have: end one first, or raise network.",
            kind == Kind::kStream ? "max_streams_per_caller" : setting)),
        kRetryAfter);
  }
  Ticket ticket(this, key.first, key.second);
  ++calls_[kind];
  ++callers_[key];
  ++all_;
  return ticket;
}

RunningCallCounts CallLimits::Running() const {
  std::map<Kind, size_t> calls;
  {
    MutexLock lock(&mutex_);
    calls = calls_;
  }
  return {calls[Kind::kStream], calls[Kind::kQuery], calls[Kind::kExport], calls[Kind::kList],
          calls[Kind::kOther]};
}

void CallLimits::Leave(const Ticket& ticket) {
  MutexLock lock(&mutex_);
  --calls_[ticket.kind_];
  const auto of_caller = callers_.find({ticket.kind_, ticket.caller_});
  if (--of_caller->second == 0) callers_.erase(of_caller);
  if (--all_ == 0) left_.SignalAll();
}

void CallLimits::Stop() {
  MutexLock lock(&mutex_);
  stopped_ = true;
}

bool CallLimits::WaitUntilIdle(absl::Time deadline) {
  MutexLock lock(&mutex_);
  while (all_ > 0) {
    if (left_.WaitWithDeadline(&mutex_, deadline)) return all_ == 0;
  }
  return true;
}

std::string MachineOf(const std::string& peer) {
  if (!absl::StartsWith(peer, "ipv")) return peer.substr(0, peer.find(':'));
  return peer.substr(0, peer.rfind(':'));
}

}  // namespace isthmus::rpc
