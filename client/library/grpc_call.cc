// The session service over gRPC, as the streams of scans call it.
#include <chrono>
#include <utility>

#include "client/library/link.h"

namespace isthmus::client {
namespace {

class GrpcWire final : public ScanWire {
 public:
  using Stream = grpc::ClientReaderWriter<v1::StreamScansRequest, v1::StreamScansResponse>;

  explicit GrpcWire(std::unique_ptr<Stream> stream) : stream_(std::move(stream)) {}

  bool Write(const v1::StreamScansRequest& request) override { return stream_->Write(request); }
  void WritesDone() override { stream_->WritesDone(); }
  bool Read(v1::StreamScansResponse* response) override { return stream_->Read(response); }
  absl::Status Finish() override { return ToStatus(stream_->Finish()); }

 private:
  const std::unique_ptr<Stream> stream_;
};

class GrpcCall final : public SessionCall {
 public:
  GrpcCall(Client::Link* link, double timeout_s) : link_(*link), stubs_(link->Get()) {
    if (timeout_s > 0) SetDeadline(timeout_s, context_);
    link->Attach(context_);
  }

  absl::Status CreateSession(const v1::CreateSessionRequest& request,
                             v1::Session* session) override {
    return Answer(stubs_->sessions->CreateSession(&context_, request, session));
  }
  absl::Status GetSession(const v1::GetSessionRequest& request, v1::Session* session) override {
    return Answer(stubs_->sessions->GetSession(&context_, request, session));
  }
  absl::Status FinishSession(const v1::FinishSessionRequest& request,
                             v1::Session* session) override {
    return Answer(stubs_->sessions->FinishSession(&context_, request, session));
  }
  std::unique_ptr<ScanWire> StreamScans() override {
    return std::make_unique<GrpcWire>(stubs_->sessions->StreamScans(&context_));
  }

  void Cancel() override { context_.TryCancel(); }
  bool connected() const override { return stubs_->channel->GetState(false) == GRPC_CHANNEL_READY; }
  void Renew() override { link_.Renew(stubs_); }

 private:
  absl::Status Answer(const grpc::Status& answer) {
    const absl::Status status = ToStatus(answer);
    if (absl::IsUnavailable(status)) Renew();
    return status;
  }

  Client::Link& link_;
  const std::shared_ptr<Client::Link::Stubs> stubs_;
  grpc::ClientContext context_;
};

}  // namespace

std::unique_ptr<SessionCall> Client::Link::NewCall(double timeout_s) {
  return std::make_unique<GrpcCall>(this, timeout_s);
}

}  // namespace isthmus::client
