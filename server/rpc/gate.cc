#include "server/rpc/gate.h"

#include <absl/strings/str_cat.h>

#include <memory>

namespace isthmus::rpc {

absl::StatusOr<Call> Gate::Admit(const grpc::ServerContextBase& context, absl::string_view rpc) {
  Call call;
  call.rpc = std::string(rpc);
  call.site = &site_;
  call.peer = context.peer();
  call.request_id = absl::StrCat(++calls_);
  call.admission = std::make_shared<Admission>();
  return call;
}

grpc::Status Gate::End(absl::string_view rpc, const absl::Status& status) const {
  if (!status.ok() && on_failed_call_) on_failed_call_(std::string(rpc), status);
  return ToGrpc(status);
}

}  // namespace isthmus::rpc
