#include "server/rpc/upload_stream.h"

#include <utility>

#include "api/convert/session.h"
#include "server/rpc/decoded_submap.h"
#include "server/rpc/streams/messages.h"

namespace isthmus::rpc {

UploadReactor::UploadReactor(StreamHost* host, grpc::CallbackServerContext* context,
                             grpc::ByteBuffer* response, uint64_t max_submap_bytes)
    : UploadReactorBase(host, &host->uploads, context, "UploadSubmap"),
      response_(*response),
      max_submap_bytes_(max_submap_bytes) {}

void UploadReactor::OnMessage(grpc::ByteBuffer message) {
  if (absl::Status status = TakePart(&message); !status.ok()) return End(status);
  GiveTime(
      host().options.progress,
      absl::DeadlineExceededError(
          "the upload stalled for too long: ask GetUpload how much arrived, then send the rest"));
  ReadNext();
}

absl::Status UploadReactor::TakePart(grpc::ByteBuffer* message) {
  v1::UploadSubmapRequest part;
  if (absl::Status status = ReadMessage(message, &part); !status.ok()) return status;
  if (!receiver_) {
    receiver_.emplace(max_submap_bytes_, call().site->staging, [weak = weak_from_this()] {
      if (const auto self = weak.lock()) {
        auto* upload = static_cast<UploadReactor*>(self.get());
        upload->Post([upload] { upload->End(TakenOver()); });
      }
    });
  }
  if (robot_.empty() && part.has_header()) {
    // Asked before the bytes come, so that a wrong name costs nothing.
    const auto session = call().FedSession(SessionId(part.header().session()));
    if (!session.ok()) return session.status();
    robot_ = session->record.robot;
  }
  return receiver_->Add(std::move(part));
}

void UploadReactor::OnReadsDone() {
  const auto info = TakeSubmap();
  if (info.ok()) {
    v1::UploadSubmapResponse response;
    response.set_session(info->id.session.value());
    response.set_index(info->id.index);
    response.set_point_count(info->point_count);
    response_ = ToBytes(response);
  }
  End(info.status());
}

absl::StatusOr<SubmapInfo> UploadReactor::TakeSubmap() {
  if (!receiver_) return absl::InvalidArgumentError("the upload ended before its header");
  auto header = receiver_->Finish();
  if (!header.ok()) return header.status();
  const SubmapId id{SessionId(header->session()), header->index()};
  auto upload = convert::FromMessage(*std::move(header));
  auto submap = upload.ok() ? DecodeSubmap(*std::move(upload), robot_) : upload.status();
  auto info =
      submap.ok() ? call().pipeline().sessions().AddSubmap(*std::move(submap)) : submap.status();
  // An upload that fails for a while need not travel again.
  const bool may_come = absl::IsUnavailable(info.status()) ||
                        absl::IsResourceExhausted(info.status()) ||
                        absl::IsOutOfRange(info.status());
  if (!may_come) call().site->staging.Drop(id);
  return info;
}

}  // namespace isthmus::rpc
