// The one place that every call passes before it is answered, over gRPC or HTTP.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>
#include <google/protobuf/message.h>
#include <grpcpp/server_context.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "api/convert/bounds.h"
#include "core/caught.h"
#include "core/concurrency/mutex.h"
#include "core/records/server_status.h"
#include "core/stopwatch.h"
#include "server/access/caller.h"
#include "server/access/require_token.h"
#include "server/access/tokens.h"
#include "server/rpc/call.h"
#include "server/rpc/call_origin.h"
#include "server/rpc/ended_call.h"
#include "server/rpc/reply.h"

namespace isthmus::rpc {

// Ok where that caller may call the method of that bare name for the site, as things are; else what
// Admit would say.
absl::Status CheckMethod(const access::Caller& caller, const Site& site, absl::string_view rpc);

// A handler that answers in its own thread is run by Serve. A reactor asks Admit first, finishes at
// once where that fails, keeps the Call as long as it lives, and lets every status that it finishes
// with go through End. Thread safe; must outlive its calls.
class Gate {
 public:
  struct Options {
    // The first is the default site, whatever its name.
    std::vector<Site*> sites;
    CallLimits* limits = nullptr;  // Never null.
    // Null: there are none, and nobody is asked for one.
    access::Tokens* tokens = nullptr;
    access::RequireToken require_token = access::RequireToken::kAuto;
    // Interval at which calls under way are asked whether their token still holds.
    std::chrono::milliseconds review_interval{1000};
    OnFailedCall on_failed_call = nullptr;  // May be null.
    OnEndedCall on_ended_call = nullptr;    // May be null.
  };

  // Everything that the options point to must outlive it.
  explicit Gate(Options options);
  ~Gate();

  // `rpc` is the method's bare name ("StreamScans"). Unauthenticated or PermissionDenied, with a
  // message that says nothing of what there is. NotFound for a site that the caller may see, and
  // that is not there. ResourceExhausted beyond a limit of calls. `token` gets the name of the
  // token that came, if it holds, whether let in or not.
  absl::StatusOr<Call> Admit(const CallOrigin& origin, absl::string_view rpc, std::string* token);

  // The status that the caller is told (ToldStatus) at the end of a call that began so long ago,
  // null if it was not let in, by a token of that name; tells of it.
  absl::Status End(absl::string_view rpc, const absl::Status& status, const CallOrigin& origin,
                   const Call* call, const std::string& token, const Stopwatch& begun) const;

  const std::vector<Site*>& sites() const { return options_.sites; }
  RunningCallCounts Running() const { return options_.limits->Running(); }

  // Answers with the status that `handler(const Call&)` returns; with that of convert::CheckBounds
  // where the request has too much of anything. What it throws is the answer to this call alone.
  template <typename Handler>
  grpc::Status Serve(grpc::ServerContextBase* context, const google::protobuf::Message& request,
                     const char* rpc, const Handler& handler) {
    return ToGrpc(Answer(*context, request, rpc, handler));
  }
  // The same for a caller that came by another way, in the thread that asks.
  template <typename Handler>
  absl::Status Answer(const CallOrigin& origin, const google::protobuf::Message& request,
                      const char* rpc, const Handler& handler) {
    const Stopwatch begun;
    LowerPriorityBelowScans();
    std::optional<Call> call;
    std::string token;
    const absl::Status status = Run(origin, request, rpc, handler, &call, &token);
    return End(rpc, status, origin, call ? &*call : nullptr, token, begun);
  }

 private:
  template <typename Handler>
  absl::Status Run(const CallOrigin& origin, const google::protobuf::Message& request,
                   const char* rpc, const Handler& handler, std::optional<Call>* call,
                   std::string* token) {
    try {
      absl::StatusOr<Call> admitted = Admit(origin, rpc, token);
      if (!admitted.ok()) return admitted.status();
      call->emplace(*std::move(admitted));
      if (auto bounds = convert::CheckBounds(request); !bounds.ok()) return bounds;
      absl::Status status = handler(std::as_const(**call));
      // A handler that was told to stop says that its client is gone, or nothing.
      const absl::Status allowed = (*call)->Allowed();
      return status.ok() || allowed.ok() ? status : allowed;
    } catch (...) {
      return CaughtStatus();
    }
  }

  // The calling thread gives way: it is one of those that answer calls.
  static void LowerPriorityBelowScans();
  // True if callers are asked for a token, as things are now.
  bool AsksForTokens() const;
  absl::StatusOr<access::Caller> Authenticate(const CallOrigin& origin) const;
  // Ok if the token of a call under way still holds; no name: the call was let in without one.
  absl::Status StillHolds(const std::string& token) const;
  absl::StatusOr<Site*> Choose(const CallOrigin& origin, const access::Caller& caller) const;
  void ReviewUntilStopped();

  const Options options_;
  std::atomic<uint64_t> calls_ = 0;
  RunningCalls running_;
  Mutex mutex_;
  CondVar stop_;
  bool stopped_ ABSL_GUARDED_BY(mutex_) = false;
  std::thread reviewer_;
};

}  // namespace isthmus::rpc
