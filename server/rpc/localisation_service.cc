#include "server/rpc/localisation_service.h"

#include <absl/strings/str_cat.h>

#include <memory>
#include <utility>

#include "api/convert/cloud.h"
#include "api/convert/localisation.h"

namespace isthmus::rpc {

grpc::Status LocalisationService::Localise(grpc::ServerContext* context, Stream* stream) {
  return gate_.Serve(context, "Localise", [&](const Call& call) -> absl::Status {
    if (!Enter(context)) return absl::UnavailableError("the server is shutting down");
    const absl::Status status = Serve(call, stream);
    Leave(context);
    return status;
  });
}

absl::Status LocalisationService::Serve(const Call& call, Stream* stream) {
  v1::LocaliseRequest request;
  std::unique_ptr<server::RobotLocaliser> localiser;
  while (stream->Read(&request)) {
    if (absl::Status allowed = call.Allowed(); !allowed.ok()) return allowed;
    if (request.has_begin() == (localiser != nullptr)) {
      return absl::InvalidArgumentError(
          localiser == nullptr ? "the first message must have begin: what the robot carries"
                               : "only the first message may have begin: open another stream");
    }
    if (request.has_begin()) {
      const auto wanted = convert::FromMessage(request.begin());
      if (!wanted.ok()) return wanted.status();
      // Whether there is a robot of that name is nothing that another robot may find out.
      if (!wanted->in_map_of.empty()) {
        if (absl::Status own = call.CheckRobot(wanted->in_map_of); !own.ok()) return own;
      }
      auto opened = call.pipeline().OpenLocaliser(*wanted);
      if (!opened.ok()) return opened.status();
      localiser = *std::move(opened);
    }
    if (!request.has_scan()) continue;
    ScanUpload scan{request.scan().sequence(), request.scan().end_stamp_ns(), {}};
    auto payload = convert::FromMessage(std::move(*request.mutable_scan()->mutable_cloud()));
    absl::StatusOr<LocalisedScan> located;
    if (payload.ok()) {
      scan.payload = *std::move(payload);
      located = localiser->Locate(scan);
      if (!located.ok()) return located.status();
    } else {
      located = LocalisedScan{.sequence = scan.sequence,
                              .rejected = std::string(payload.status().message())};
    }
    if (!stream->Write(convert::ToMessage(*located))) break;
  }
  return absl::OkStatus();
}

bool LocalisationService::Enter(grpc::ServerContext* context) {
  MutexLock lock(&mutex_);
  if (!stopped_) streams_.insert(context);
  return !stopped_;
}

void LocalisationService::Leave(grpc::ServerContext* context) {
  MutexLock lock(&mutex_);
  streams_.erase(context);
}

void LocalisationService::StopAll() {
  MutexLock lock(&mutex_);
  stopped_ = true;
  for (grpc::ServerContext* context : streams_) context->TryCancel();
}

}  // namespace isthmus::rpc
