#include "server/web/map_read.h"

#include <chrono>
#include <utility>

#include "server/rpc/call_origin.h"
#include "server/web/answers.h"
#include "server/web/caller.h"
#include "server/web/limits.h"

namespace isthmus::web {

absl::Status PassGate(rpc::Gate& gate, const http::Request& request, const char* rpc,
                      const google::protobuf::Message& asked,
                      const std::function<absl::Status(const rpc::Call& call)>& read) {
  using std::chrono::steady_clock;
  const auto end = steady_clock::now() + kCallTime;
  const http::Fields fields = CallHeaders(request);
  rpc::CallOrigin::Headers headers;
  for (const auto& [name, value] : fields) headers.emplace(name, value);
  const rpc::CallOrigin origin(&headers, request.peer, [&request, end] {
    return request.gone() || steady_clock::now() >= end;
  });
  const absl::Status status = gate.Answer(origin, asked, rpc, read);
  const bool is_late = absl::IsCancelled(status) && steady_clock::now() >= end;
  return is_late ? absl::DeadlineExceededError("Deadline Exceeded") : status;
}

http::Response ReadMap(rpc::Gate& gate, const http::Request& request, const char* rpc,
                       const google::protobuf::Message& asked, const MapRead& read) {
  http::Response response;
  const absl::Status status = PassGate(gate, request, rpc, asked, [&](const rpc::Call& call) {
    auto made = read(call);
    if (made.ok()) response = *std::move(made);
    return made.status();
  });
  return status.ok() ? std::move(response) : ErrorAnswer(status);
}

}  // namespace isthmus::web
