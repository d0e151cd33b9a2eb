#include "server/rpc/back_up.h"

#include <absl/cleanup/cleanup.h>

#include <string>
#include <utility>

#include "server/rpc/file_emitter.h"

namespace isthmus::rpc {
namespace {

constexpr double kTellEvery = 0.01;  // Share of the copy.

void SetContents(const BackupContents& contents, v1::BackupContents* message) {
  message->set_sessions(contents.sessions);
  message->set_submaps(contents.submaps);
  message->set_scans(contents.scans);
  message->set_points(contents.points);
  message->set_damaged(contents.damaged);
  message->set_report(contents.report);
}

}  // namespace

absl::Status BackUp(server::Pipeline& pipeline, const BackupSource& source, std::atomic<bool>& busy,
                    const v1::BackUpRequest&, const Emit<v1::BackUpResponse>& emit) {
  if (!source) return absl::UnimplementedError("this server stores nothing that could be kept");
  if (busy.exchange(true)) {
    return absl::ResourceExhaustedError("another backup is under way; try again when it is done");
  }
  const absl::Cleanup done = [&busy] { busy = false; };
  const int64_t revision = pipeline.GetMapInfo().revision;
  BackupContents contents;
  // The last response says what is in the backup, too.
  const Emit<v1::BackUpResponse> with_contents = [&](const v1::BackUpResponse& response) {
    if (!response.last()) return emit(response);
    v1::BackUpResponse last = response;
    SetContents(contents, last.mutable_contents());
    return emit(last);
  };
  FileEmitter<v1::BackUpResponse> file(revision, with_contents);
  v1::BackUpResponse state;
  state.set_revision(revision);
  BackupSink sink;
  sink.progress = [&](double share) {
    if (share < state.copied() + kTellEvery) return true;
    state.set_copied(share);
    return emit(state);
  };
  sink.begin = [&](uint64_t size) {
    state.set_copied(1);
    state.set_total_bytes(size);
    emit(state);  // A reader that is gone shows at the first piece.
  };
  sink.piece = [&](const std::string& piece) { return file.Add(piece); };
  absl::StatusOr<BackupContents> made = source(sink);
  if (!made.ok()) return made.status();
  contents = *std::move(made);
  return file.Finish() ? absl::OkStatus() : ReaderGone();
}

}  // namespace isthmus::rpc
