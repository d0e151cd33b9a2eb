// Looking after the server itself. api/isthmus/v1/admin_service.proto says what each method returns
// and fails with.
#include <absl/cleanup/cleanup.h>
#include <absl/strings/str_cat.h>

#include <string>
#include <utility>

#include "api/convert/graph.h"
#include "api/convert/status.h"
#include "core/clock.h"
#include "core/io/process_use.h"
#include "core/stopwatch.h"
#include "isthmus/v1/admin_service.grpc.pb.h"
#include "server/access/methods.h"
#include "server/rpc/health_watch.h"
#include "server/rpc/responses.h"
#include "server/rpc/services.h"

namespace isthmus::rpc {
namespace {

constexpr double kTellEvery = 0.01;  // Share of the copy.

absl::Status SendBackup(const Call& call, const std::string& tokens,
                        grpc::ServerWriter<v1::BackUpResponse>* writer) {
  if (!call.site->backup)
    return absl::UnimplementedError("this server stores nothing that could be kept");
  if (call.site->backing_up.exchange(true)) {
    return absl::ResourceExhaustedError("another backup is under way; try again when it is done");
  }
  const absl::Cleanup done = [&call] { call.site->backing_up = false; };
  v1::BackUpResponse state;
  state.set_revision(call.pipeline().GetMapInfo().revision);
  FileEmitter<v1::BackUpResponse> file(call, writer);
  file.SetRevision(state.revision());
  BackupSink sink;
  sink.progress = [&](double share) {
    if (share < state.copied() + kTellEvery) return true;
    state.set_copied(share);
    return writer->Write(state);
  };
  sink.begin = [&](uint64_t size) {
    state.set_copied(1);
    state.set_total_bytes(size);
    writer->Write(state);  // A reader that is gone shows at the first piece.
  };
  sink.piece = [&](const std::string& piece) { return file.Add(piece); };
  const absl::StatusOr<BackupContents> contents = call.site->backup(sink);
  if (!contents.ok()) return contents.status();
  v1::BackUpResponse last;
  *last.mutable_contents() = convert::ToMessage(*contents);
  last.set_tokens(tokens);
  absl::Status status = file.Finish(std::move(last));
  if (status.ok()) {
    Event event;
    event.kind = EventKind::kBackupMade;
    event.actor = call.actor();
    event.text = absl::StrCat("backup made: ", contents->sessions, " sessions, ", contents->submaps,
                              " submaps");
    call.pipeline().events().Note(std::move(event));
  }
  return status;
}

class AdminService final : public v1::AdminService::Service {
 public:
  explicit AdminService(const ServiceParts& parts)
      : gate_(parts.gate), tokens_(parts.tokens), web_address_(parts.web_address) {}

  grpc::Status BackUp(grpc::ServerContext* context, const v1::BackUpRequest* request,
                      grpc::ServerWriter<v1::BackUpResponse>* writer) override {
    return gate_.Serve(context, *request, "BackUp", [&](const Call& call) {
      const bool with_tokens = request->tokens() && tokens_ != nullptr;
      return SendBackup(call, with_tokens ? tokens_->PrintThoseOf(call.site->name) : "", writer);
    });
  }

  grpc::Status GetStatus(grpc::ServerContext* context, const v1::GetStatusRequest* request,
                         v1::ServerStatus* response) override {
    return gate_.Serve(context, *request, "GetStatus", [&](const Call& call) -> absl::Status {
      ServerStatus status;
      status.version = ISTHMUS_VERSION;
      status.site = call.site->name;
      status.started_ns = started_ns_;
      status.uptime_s = up_.Ms() / 1000;
      status.process = io::UseOfThisProcess();
      status.calls = gate_.Running();
      status.uploads = call.site->staging.under_way();
      status.load = call.pipeline().GetLoad();
      status.degraded = FindDegraded(status.load);
      status.web_address = web_address_.Get();
      for (const access::Method& method : access::Methods()) {
        const absl::Status may = CheckMethod(call.caller, *call.site, method.name);
        if (may.ok()) continue;
        status.refused.push_back({std::string(method.name), std::string(may.message())});
      }
      *response = convert::ToMessage(status);
      return absl::OkStatus();
    });
  }

 private:
  Gate& gate_;
  access::Tokens* const tokens_;
  const WebAddress& web_address_;
  const int64_t started_ns_ = Clock::System().NowNs();
  const Stopwatch up_;
};

}  // namespace

std::unique_ptr<grpc::Service> MakeAdminService(const ServiceParts& parts) {
  return std::make_unique<AdminService>(parts);
}

}  // namespace isthmus::rpc
