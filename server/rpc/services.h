// The services of the API, each made by one function; their handlers are declared by the generated
// classes alone.
#pragma once

#include <grpcpp/impl/codegen/service_type.h>

#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "core/concurrency/mutex.h"
#include "server/access/tokens.h"
#include "server/rpc/gate.h"
#include "server/rpc/streams/stream_host.h"

namespace isthmus::rpc {

// The address at which browsers are served, once it is known. Thread safe.
class WebAddress {
 public:
  void Set(std::string address) {
    MutexLock lock(&mutex_);
    address_ = std::move(address);
  }
  std::string Get() const {
    MutexLock lock(&mutex_);
    return address_;
  }

 private:
  mutable Mutex mutex_;
  std::string address_ ABSL_GUARDED_BY(mutex_);
};

// Shared by the services, which it outlives.
struct ServiceParts {
  Gate& gate;
  StreamHost& host;
  access::Tokens* tokens;  // May be null.
  // Bytes of an uploaded submap, as it travels.
  uint64_t max_submap_bytes;
  const WebAddress& web_address;
};

// Thread safe, each of them.
std::unique_ptr<grpc::Service> MakeSessionService(const ServiceParts& parts);
std::unique_ptr<grpc::Service> MakeMapService(const ServiceParts& parts);
std::unique_ptr<grpc::Service> MakeEditService(const ServiceParts& parts);
std::unique_ptr<grpc::Service> MakeEventService(const ServiceParts& parts);
std::unique_ptr<grpc::Service> MakeLocalisationService(const ServiceParts& parts);
std::unique_ptr<grpc::Service> MakeAdminService(const ServiceParts& parts);
std::unique_ptr<grpc::Service> MakeAccessService(const ServiceParts& parts);

}  // namespace isthmus::rpc
