#include "client/library/localisation.h"

#include <grpcpp/client_context.h>

#include <memory>
#include <utility>

#include "api/convert/cloud.h"
#include "api/convert/localisation.h"
#include "client/library/client.h"
#include "client/library/link.h"
#include "client/library/stream/scan_stream_impl.h"

namespace isthmus::client {

class Localisation::Impl {
 public:
  Impl(std::shared_ptr<Client::Link> link, const LocalisationRequest& request,
       const LocalisationOptions& options)
      : link_(std::move(link)), begin_(convert::ToMessage(request)), options_(options) {}
  ~Impl() {
    if (stream_ == nullptr) return;
    context_->TryCancel();
    stream_->Finish();
  }

  absl::StatusOr<LocalisedScan> Locate(int64_t end_stamp_ns, PointPayload payload) {
    ScanStreamOptions compression;
    compression.resolution_m = options_.resolution_m;
    // There is no session that tells which versions the server reads: the one that all do.
    auto prepared = Prepare(std::move(payload), compression, 1);
    if (!prepared.ok()) return prepared.status();
    v1::LocaliseRequest request;
    request.mutable_scan()->set_sequence(++sequence_);
    request.mutable_scan()->set_end_stamp_ns(end_stamp_ns);
    *request.mutable_scan()->mutable_cloud() = convert::ToMessage(*std::move(prepared));
    v1::LocaliseResponse response;
    const absl::Status status = link_->Repeat(false, [&] { return Ask(&request, &response); });
    if (!status.ok()) return status;
    return convert::FromMessage(response);
  }

 private:
  void Open() {
    stubs_ = link_->Get();
    context_ = std::make_unique<grpc::ClientContext>();
    link_->Attach(*context_);
    stream_ = stubs_->localisation->Localise(context_.get());
  }

  // One attempt, on the stream that there is or on a new one.
  absl::Status Ask(v1::LocaliseRequest* request, v1::LocaliseResponse* response) {
    if (stream_ == nullptr) {
      Open();
      *request->mutable_begin() = begin_;
    }
    const bool answered = stream_->Write(*request) && stream_->Read(response);
    request->clear_begin();
    return answered ? absl::OkStatus() : Close();
  }

  // The stream has ended; returns why, never OK.
  absl::Status Close() {
    const absl::Status status = ToStatus(stream_->Finish());
    stream_.reset();
    context_.reset();
    if (absl::IsUnavailable(status)) link_->Renew(stubs_);
    // A stream that the server ended by itself is one to be opened again.
    return status.ok() || absl::IsCancelled(status)
               ? absl::UnavailableError("the stream of places was cut off")
               : status;
  }

  const std::shared_ptr<Client::Link> link_;
  const v1::LocaliseBegin begin_;
  const LocalisationOptions options_;
  uint64_t sequence_ = 0;
  std::shared_ptr<Client::Link::Stubs> stubs_;
  std::unique_ptr<grpc::ClientContext> context_;
  std::unique_ptr<grpc::ClientReaderWriter<v1::LocaliseRequest, v1::LocaliseResponse>> stream_;
};

Localisation::Localisation(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

Localisation::~Localisation() = default;

absl::StatusOr<LocalisedScan> Localisation::Locate(int64_t end_stamp_ns, PointPayload payload) {
  return impl_->Locate(end_stamp_ns, std::move(payload));
}

std::unique_ptr<Localisation> Client::OpenLocalisation(const LocalisationRequest& request,
                                                       const LocalisationOptions& options) {
  return std::make_unique<Localisation>(
      std::make_unique<Localisation::Impl>(link_, request, options));
}

}  // namespace isthmus::client
