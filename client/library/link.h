// The connection behind a client, over gRPC. Private to the library.
#pragma once

#include <absl/status/status.h>
#include <grpcpp/channel.h>
#include <grpcpp/client_context.h>
#include <grpcpp/support/status.h>

#include <functional>
#include <memory>
#include <string>

#include "client/library/client.h"
#include "client/library/stream/session_link.h"
#include "core/concurrency/mutex.h"
#include "isthmus/v1/access_service.grpc.pb.h"
#include "isthmus/v1/admin_service.grpc.pb.h"
#include "isthmus/v1/edit_service.grpc.pb.h"
#include "isthmus/v1/event_service.grpc.pb.h"
#include "isthmus/v1/localisation_service.grpc.pb.h"
#include "isthmus/v1/map_service.grpc.pb.h"
#include "isthmus/v1/session_service.grpc.pb.h"

namespace isthmus::client {

// Thread safe.
class Client::Link final : public SessionLink {
 public:
  struct Stubs {
    std::shared_ptr<grpc::Channel> channel;
    std::unique_ptr<v1::SessionService::Stub> sessions;
    std::unique_ptr<v1::MapService::Stub> maps;
    std::unique_ptr<v1::EditService::Stub> edits;
    std::unique_ptr<v1::AdminService::Stub> admin;
    std::unique_ptr<v1::AccessService::Stub> access;
    std::unique_ptr<v1::LocalisationService::Stub> localisation;
    std::unique_ptr<v1::EventService::Stub> events;
  };
  // One attempt at a call. Must not have effects that a second attempt would double.
  using Attempt = std::function<grpc::Status(Stubs&, grpc::ClientContext&)>;

  explicit Link(const ClientOptions& options);

  std::unique_ptr<SessionCall> NewCall(double timeout_s) override;

  // The stubs of the current channel.
  std::shared_ptr<Stubs> Get();
  // Replaces the channel, unless another thread already replaced `broken`: a fresh one connects at
  // once, where an old one first waits out gRPC's own back-off. With several addresses it is to the
  // next.
  void Renew(const std::shared_ptr<Stubs>& broken);

  // A single attempt, whatever comes of it.
  absl::Status Once(double timeout_s, const Attempt& attempt);
  // Attempts until one does not end in UNAVAILABLE, waiting in between.
  absl::Status Call(double timeout_s, const Attempt& attempt);
  // A single attempt, after making sure that the server answers: for calls with effects that must
  // not be doubled.
  absl::Status CallOnce(double timeout_s, const Attempt& attempt);
  // Adds what every call carries: token and site. Before the call begins.
  void Attach(grpc::ClientContext& context) const;
  // Any call that answers at once.
  absl::Status Probe();

 private:
  Mutex mutex_;
  size_t current_ ABSL_GUARDED_BY(mutex_) = 0;  // Index of the address in use.
  std::shared_ptr<Stubs> stubs_ ABSL_GUARDED_BY(mutex_);
};

absl::Status ToStatus(const grpc::Status& status);
void SetDeadline(double timeout_s, grpc::ClientContext& context);

// For streams whose first part has been handed on: Unavailable becomes Aborted, so that it is not
// begun again.
absl::Status NotAgain(const absl::Status& status);

}  // namespace isthmus::client
