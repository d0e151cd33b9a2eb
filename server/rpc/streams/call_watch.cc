#include "server/rpc/streams/call_watch.h"

#include <absl/status/status.h>
#include <absl/strings/str_cat.h>
#include <grpcpp/server_context.h>

#include "api/convert/retry_after.h"

namespace isthmus::rpc {
namespace {

using grpc::experimental::InterceptionHookPoints;
using grpc::experimental::InterceptorBatchMethods;

class CallWatch final : public grpc::experimental::Interceptor {
 public:
  CallWatch(Watchdog* watchdog, std::chrono::milliseconds progress,
            grpc::ServerContextBase* context)
      : progress_(progress), timer_(watchdog, [context] { context->TryCancel(); }) {}

  void Intercept(InterceptorBatchMethods* methods) override {
    const auto is_at = [&](InterceptionHookPoints point) {
      return methods->QueryInterceptionHookPoint(point);
    };
    if (is_at(InterceptionHookPoints::PRE_SEND_STATUS)) {
      AddRetryAfter(methods);
      ending_ = true;
      timer_.Arm(progress_);
    } else if (is_at(InterceptionHookPoints::PRE_SEND_MESSAGE)) {
      timer_.Arm(progress_);
    }
    if (is_at(InterceptionHookPoints::POST_SEND_MESSAGE) && !ending_) timer_.Disarm();
    // From here on the context may go.
    if (is_at(InterceptionHookPoints::POST_RECV_CLOSE)) timer_.Disarm();
    methods->Proceed();
  }

 private:
  static void AddRetryAfter(InterceptorBatchMethods* methods) {
    const grpc::Status status = methods->GetSendStatus();
    if (status.ok()) return;
    const auto after =
        convert::RetryAfter(convert::WithDetails(absl::UnknownError(""), status.error_details()));
    auto* trailers = methods->GetSendTrailingMetadata();
    if (!after || trailers == nullptr) return;
    trailers->insert({"retry-after-ms", absl::StrCat(after->count())});
  }

  const std::chrono::milliseconds progress_;
  Watchdog::Timer timer_;
  bool ending_ = false;  // Its status is on its way.
};

}  // namespace

grpc::experimental::Interceptor* CallWatchFactory::CreateServerInterceptor(
    grpc::experimental::ServerRpcInfo* info) {
  return new CallWatch(&watchdog_, progress_, info->server_context());  // gRPC owns it.
}

}  // namespace isthmus::rpc
