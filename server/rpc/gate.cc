#include "server/rpc/gate.h"

#include <absl/strings/str_cat.h>

#include <memory>
#include <utility>

namespace isthmus::rpc {

absl::StatusOr<Call> Gate::Admit(const grpc::ServerContextBase& context, absl::string_view rpc) {
  auto ticket = limits_.Enter(rpc, MachineOf(context.peer()));
  if (!ticket.ok()) return ticket.status();
  Call call;
  call.ticket.emplace(*std::move(ticket));
  call.context = &context;
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
