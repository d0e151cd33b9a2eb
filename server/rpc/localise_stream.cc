#include "server/rpc/localise_stream.h"

#include <string>
#include <utility>

#include "api/convert/cloud.h"
#include "api/convert/localisation.h"
#include "server/rpc/reply.h"
#include "server/rpc/streams/messages.h"

namespace isthmus::rpc {

absl::Status LocaliseReactor::Open(const v1::LocaliseRequest& request) {
  if (request.has_begin() == (localiser_ != nullptr)) {
    return absl::InvalidArgumentError(
        localiser_ == nullptr ? "the first message must have begin: what the robot carries"
                              : "only the first message may have begin: open another stream");
  }
  if (!request.has_begin()) return absl::OkStatus();
  const auto wanted = convert::FromMessage(request.begin());
  if (!wanted.ok()) return wanted.status();
  // Whether there is a robot of that name is nothing that another robot may find out.
  if (!wanted->in_map_of.empty()) {
    if (absl::Status own = call().CheckRobot(wanted->in_map_of); !own.ok()) return own;
  }
  auto opened = call().pipeline().OpenLocaliser(*wanted);
  if (!opened.ok()) return opened.status();
  localiser_ = *std::move(opened);
  return absl::OkStatus();
}

absl::StatusOr<LocalisedScan> LocaliseReactor::Locate(v1::LocaliseRequest* request) {
  ScanUpload scan{request->scan().sequence(), request->scan().end_stamp_ns(), {}};
  auto payload = convert::FromMessage(std::move(*request->mutable_scan()->mutable_cloud()));
  if (!payload.ok()) {
    return LocalisedScan{.sequence = scan.sequence,
                         .rejected = std::string(payload.status().message())};
  }
  scan.payload = *std::move(payload);
  return localiser_->Locate(scan);
}

void LocaliseReactor::OnMessage(grpc::ByteBuffer message) {
  v1::LocaliseRequest request;
  absl::Status status = ReadMessage(&message, &request);
  if (status.ok()) status = Open(request);
  if (!status.ok()) return End(status);
  if (!request.has_scan()) return ReadNext();
  absl::StatusOr<LocalisedScan> located = Locate(&request);
  if (!located.ok()) return End(located.status());
  located->rejected = CutText(located->rejected, kMaxReason);
  place_ = ToBytes(convert::ToMessage(*located));
  StartWrite(&place_);
}

void LocaliseReactor::OnWriteDone(bool ok) {
  Post([this, ok] {
    if (!ok) return End(absl::CancelledError("the client went away"));
    ReadNext();
  });
}

}  // namespace isthmus::rpc
