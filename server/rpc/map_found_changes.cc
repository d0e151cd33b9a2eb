// Changes in the map between two times.
#include "api/convert/changed_volumes.h"
#include "server/rpc/map_answers.h"
#include "server/rpc/responses.h"

namespace isthmus::rpc {

absl::Status SendChanges(const Call& call, const v1::FindChangesRequest& request,
                         grpc::ServerWriter<v1::FindChangesResponse>* writer) {
  const auto query = convert::FromMessage(request);
  if (!query.ok()) return query.status();
  const auto changes = call.pipeline().reader().FindChanges(
      *query, [&] { return !call.Gone() && call.Allowed().ok(); });
  if (!changes.ok()) return changes.status();
  v1::FindChangesResponse head;
  head.set_revision(changes->revision);
  head.set_submaps_before(changes->submaps_before);
  head.set_submaps_after(changes->submaps_after);
  head.set_left_out(changes->left_out);
  ListEmitter<v1::FindChangesResponse> list(call, head, writer);
  for (const ChangedVolume& volume : changes->volumes) {
    list.Add(&v1::FindChangesResponse::mutable_volumes, convert::ToMessage(volume));
  }
  return list.Finish();
}

}  // namespace isthmus::rpc
