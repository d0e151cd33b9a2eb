#include "server/rpc/admin_service.h"

#include <absl/cleanup/cleanup.h>

#include <string>

#include "api/convert/graph.h"
#include "server/rpc/responses.h"

namespace isthmus::rpc {
namespace {

constexpr double kTellEvery = 0.01;  // Share of the copy.

}  // namespace

absl::Status AdminService::SendBackup(grpc::ServerWriter<v1::BackUpResponse>* writer) {
  if (!source_) return absl::UnimplementedError("this server stores nothing that could be kept");
  if (backing_up_.exchange(true)) {
    return absl::ResourceExhaustedError("another backup is under way; try again when it is done");
  }
  const absl::Cleanup done = [this] { backing_up_ = false; };
  v1::BackUpResponse state;
  state.set_revision(pipeline_.GetMapInfo().revision);
  FileEmitter<v1::BackUpResponse> file(state.revision(), writer);
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
  const absl::StatusOr<BackupContents> contents = source_(sink);
  if (!contents.ok()) return contents.status();
  v1::BackUpResponse last;
  *last.mutable_contents() = convert::ToMessage(*contents);
  return file.Finish(std::move(last));
}

grpc::Status AdminService::BackUp(grpc::ServerContext*, const v1::BackUpRequest*,
                                  grpc::ServerWriter<v1::BackUpResponse>* writer) {
  return reply_("BackUp", [&] { return SendBackup(writer); });
}

}  // namespace isthmus::rpc
