#include "server/rpc/gate.h"

#include <absl/strings/ascii.h>
#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "core/concurrency/thread_role.h"
#include "server/access/limits.h"
#include "server/access/methods.h"

namespace isthmus::rpc {
namespace {

constexpr char kAuthorization[] = "authorization", kSite[] = "isthmus-site",
               kRequestId[] = "x-request-id";
constexpr char kHowToSend[] =
    "send one as `authorization: Bearer TOKEN` (isthmus: --token-file FILE, or ISTHMUS_TOKEN)";
// A reader has time, a scan has not: of a core that both want, what answers calls gets half of what
// takes scans in. A guess: less than what makes the map, which nobody waits for.
constexpr int kAnswersNice = 3;
constexpr size_t kMaxSecret = 256;  // Nobody's is as long; what is longer is not hashed.

// The values of a key; nothing where it is given twice.
std::optional<std::string> OnlyValue(const CallOrigin& origin, const char* key, bool* twice) {
  const auto [begin, end] = origin.headers.equal_range(key);
  *twice = begin != end && std::next(begin) != end;
  if (begin == end || *twice) return std::nullopt;
  return std::string(begin->second.data(), begin->second.size());
}

absl::StatusOr<std::string> SecretOf(const CallOrigin& origin) {
  constexpr absl::string_view kScheme = "Bearer ";
  bool twice = false;
  const std::optional<std::string> value = OnlyValue(origin, kAuthorization, &twice);
  if (!value && !twice) {
    return absl::UnauthenticatedError(
        absl::StrCat("this server asks for a token, and none came: ", kHowToSend,
                     "; an administrator makes it with `isthmus token create`"));
  }
  if (!value || !absl::StartsWithIgnoreCase(*value, kScheme) ||
      value->size() > kScheme.size() + kMaxSecret) {
    return absl::UnauthenticatedError(absl::StrCat("that is not a token: ", kHowToSend));
  }
  return value->substr(kScheme.size());
}

bool IsPlain(const std::string& id) {
  constexpr size_t kLongest = 64;
  return !id.empty() && id.size() <= kLongest && std::all_of(id.begin(), id.end(), [](char c) {
    return absl::ascii_isalnum(static_cast<unsigned char>(c)) || c == '-' || c == '_' || c == '.';
  });
}

// The client's own, where it is plain; else empty.
std::string GivenRequestId(const CallOrigin& origin) {
  bool twice = false;
  const std::optional<std::string> id = OnlyValue(origin, kRequestId, &twice);
  return id && IsPlain(*id) ? *id : std::string();
}

// An error if the site is only read. A robot, or a person with one at hand, may have been given
// this address with others: after Unavailable it goes on to the next. A person who decides is told.
absl::Status CheckTakesChanges(const Site& site, const access::Method& method) {
  if (!method.changes) return absl::OkStatus();
  absl::Status status = site.pipeline.CheckTakesChanges();
  if (status.ok() || !method.IsForRobots()) return status;
  return absl::UnavailableError(status.message());
}

}  // namespace

absl::Status CheckMethod(const access::Caller& caller, const Site& site, absl::string_view rpc) {
  const auto method = access::AllowedMethod(caller, rpc);
  return method.ok() ? CheckTakesChanges(site, **method) : method.status();
}

Gate::Gate(Options options) : options_(std::move(options)) {
  if (options_.tokens != nullptr) reviewer_ = std::thread([this] { ReviewUntilStopped(); });
}

Gate::~Gate() {
  {
    MutexLock lock(&mutex_);
    stopped_ = true;
    stop_.SignalAll();
  }
  if (reviewer_.joinable()) reviewer_.join();
}

void Gate::ReviewUntilStopped() {
  MutexLock lock(&mutex_);
  while (!stopped_) {
    stop_.WaitFor(&mutex_, options_.review_interval);
    if (stopped_) return;
    mutex_.Unlock();
    running_.Review([this](const std::string& token) { return StillHolds(token); });
    mutex_.Lock();
  }
}

void Gate::LowerPriorityBelowScans() {
  // gRPC makes these threads, and ends them as it pleases.
  [[maybe_unused]] thread_local const bool gives_way = [] {
    LowerPriority(kAnswersNice);
    return true;
  }();
}

bool Gate::AsksForTokens() const {
  if (options_.tokens == nullptr) return false;
  switch (options_.require_token) {
    case access::RequireToken::kAlways:
      return true;
    case access::RequireToken::kNever:
      return false;
    case access::RequireToken::kAuto:
      return options_.tokens->any();
  }
  return true;
}

absl::StatusOr<access::Caller> Gate::Authenticate(const CallOrigin& origin) const {
  if (!AsksForTokens()) return access::Caller();
  const absl::StatusOr<std::string> secret = SecretOf(origin);
  if (!secret.ok()) return secret.status();
  auto token = options_.tokens->Check(*secret);
  if (!token.ok()) return token.status();
  return access::Caller{token->name, token->role, std::move(token->robots),
                        std::move(token->sites)};
}

absl::Status Gate::StillHolds(const std::string& token) const {
  if (!AsksForTokens()) return absl::OkStatus();
  if (!token.empty()) return options_.tokens->StillHolds(token);
  return absl::UnauthenticatedError(
      absl::StrCat("this server asks for a token since just now: ", kHowToSend));
}

absl::StatusOr<Site*> Gate::Choose(const CallOrigin& origin, const access::Caller& caller) const {
  bool twice = false;
  std::optional<std::string> wanted = OnlyValue(origin, kSite, &twice);
  if (twice) return absl::InvalidArgumentError("a call is about one site: name it once");
  if (!wanted) {
    const bool has_one = caller.sites.size() == 1 && !absl::StrContains(caller.sites[0], '*');
    wanted = has_one ? caller.sites[0] : options_.sites.front()->name;
  }
  if (!caller.MaySee(*wanted)) {
    return absl::PermissionDeniedError(
        "this token is not for that site: name another one (isthmus: --site NAME), or ask an "
        "administrator for a token that is");
  }
  for (Site* site : options_.sites) {
    if (site->name == *wanted) return site;
  }
  return absl::NotFoundError(
      "this server has no site of that name: the section `sites` of its settings lists its sites");
}

absl::StatusOr<Call> Gate::Admit(const CallOrigin& origin, absl::string_view rpc,
                                 std::string* token) {
  auto caller = Authenticate(origin);
  if (!caller.ok()) return caller.status();
  *token = caller->token;
  const auto method = access::AllowedMethod(*caller, rpc);
  if (!method.ok()) return method.status();
  const absl::StatusOr<Site*> site = Choose(origin, *caller);
  if (!site.ok()) return site.status();
  if (absl::Status status = CheckTakesChanges(**site, **method); !status.ok()) return status;
  // A token is one caller wherever it calls from; without, a machine is.
  const std::string who =
      caller->token.empty() ? MachineOf(origin.peer) : absl::StrCat("token ", caller->token);
  auto ticket = options_.limits->Enter((*method)->kind, who);
  if (!ticket.ok()) return ticket.status();
  Call call;
  call.ticket.emplace(*std::move(ticket));
  call.gone = origin.gone;
  call.rpc = std::string(rpc);
  call.caller = *std::move(caller);
  call.site = *site;
  call.peer = origin.peer;
  call.request_id = GivenRequestId(origin);
  if (call.request_id.empty()) call.request_id = absl::StrCat(++calls_);
  call.admission = std::make_shared<Admission>();
  if (options_.tokens != nullptr) {
    call.running = &running_;
    running_.Enter(call.admission, call.caller.token, origin.cancel);
  }
  return call;
}

absl::Status Gate::End(absl::string_view rpc, const absl::Status& status, const CallOrigin& origin,
                       const Call* call, const std::string& token, const Stopwatch& begun) const {
  if (options_.on_ended_call) {
    options_.on_ended_call(std::string(rpc), status.code(), 1e-3 * begun.Ms());
  }
  if (status.ok() || !options_.on_failed_call) return ToldStatus(status);
  FailedCall failed;
  failed.rpc = std::string(rpc);
  failed.status = status;
  failed.token = token;
  if (call != nullptr) {
    failed.peer = call->peer;
    failed.request_id = call->request_id;
    failed.site = call->site->name;
  } else {
    failed.peer = origin.peer;
    failed.request_id = GivenRequestId(origin);
  }
  options_.on_failed_call(failed);
  return ToldStatus(status);
}

}  // namespace isthmus::rpc
