#include "server/rpc/export_pose_graph.h"

#include <string>

#include "server/rpc/file_emitter.h"

namespace isthmus::rpc {

absl::Status ExportPoseGraph(server::Pipeline& pipeline, const v1::ExportPoseGraphRequest& request,
                             const Emit<v1::ExportPoseGraphResponse>& emit) {
  FileEmitter<v1::ExportPoseGraphResponse> file(pipeline.GetMapInfo().revision, emit);
  const absl::StatusOr<std::string> graph = pipeline.ExportPoseGraph(request.component());
  if (!graph.ok()) return graph.status();
  return file.Add(*graph) && file.Finish() ? absl::OkStatus() : ReaderGone();
}

}  // namespace isthmus::rpc
