// The map and its pose graph as files.
#include <string>

#include "api/convert/map.h"
#include "api/convert/map_name.h"
#include "server/rpc/map_answers.h"
#include "server/rpc/responses.h"

namespace isthmus::rpc {

absl::Status SendMap(const Call& call, const v1::ExportMapRequest& request,
                     grpc::ServerWriter<v1::ExportMapResponse>* writer) {
  const auto wanted = convert::FromMessage(request);
  if (!wanted.ok()) return wanted.status();
  FileEmitter<v1::ExportMapResponse> file(call, writer);
  const absl::Status status = call.pipeline().reader().ExportMap(
      *wanted, [&file](int64_t revision) { file.SetRevision(revision); },
      [&](const std::string& piece) { return !call.Gone() && file.Add(piece); });
  return status.ok() ? file.Finish() : status;
}

absl::Status SendPoseGraph(const Call& call, const v1::ExportPoseGraphRequest& request,
                           grpc::ServerWriter<v1::ExportPoseGraphResponse>* writer) {
  FileEmitter<v1::ExportPoseGraphResponse> file(call, writer);
  file.SetRevision(call.pipeline().GetMapInfo().revision);
  const absl::StatusOr<std::string> graph =
      call.pipeline().ExportPoseGraph(convert::MapOf(request));
  if (!graph.ok()) return graph.status();
  return file.Add(*graph) ? file.Finish() : ReaderGone();
}

}  // namespace isthmus::rpc
