#include "client/library/link.h"

#include <absl/strings/str_cat.h>
#include <grpcpp/create_channel.h>
#include <grpcpp/security/credentials.h>
#include <grpcpp/support/channel_arguments.h>

#include <chrono>

#include "api/convert/retry_after.h"
#include "core/io/file_io.h"

namespace isthmus::client {
namespace {

// A radio link that is dead is noticed within the sum of these; the server permits it. One that is
// merely slow answers a ping behind the scans that are under way.
constexpr int kPingEveryMs = 5'000, kPingTimeoutMs = 10'000;
// Longest time to make a connection when another server may have the map: a host that is gone, or a
// server that hangs, answers nothing. Else gRPC's 20 s, for the slowest of links.
constexpr int kConnectingMs = 5'000;

// Empty where there is no such file: the handshake says what is missing.
std::string Contents(const std::string& path) {
  if (path.empty()) return {};
  const auto bytes = io::ReadFile(path);
  return bytes.ok() ? *bytes : std::string();
}

std::shared_ptr<grpc::ChannelCredentials> CredentialsOf(const TlsOptions& tls) {
  if (tls.ca.empty()) return grpc::InsecureChannelCredentials();
  grpc::SslCredentialsOptions options;
  if (tls.ca != "system") options.pem_root_certs = Contents(tls.ca);
  options.pem_cert_chain = Contents(tls.certificate);
  options.pem_private_key = Contents(tls.key);
  return grpc::SslCredentials(options);
}

std::shared_ptr<Client::Link::Stubs> Open(const ClientOptions& options, const std::string& address,
                                          bool is_one_of_several) {
  grpc::ChannelArguments arguments;
  if (!options.tls.server_name.empty()) {
    arguments.SetSslTargetNameOverride(options.tls.server_name);
  }
  arguments.SetMaxSendMessageSize(-1);  // The server's own limit decides, and says so.
  // Not shared with other channels to the address, so that a new channel tries at once.
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, kPingEveryMs);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, kPingTimeoutMs);
  arguments.SetInt(GRPC_ARG_HTTP2_MAX_PINGS_WITHOUT_DATA, 0);  // No limit.
  if (is_one_of_several) arguments.SetInt(GRPC_ARG_MIN_RECONNECT_BACKOFF_MS, kConnectingMs);
  auto stubs = std::make_shared<Client::Link::Stubs>();
  stubs->channel = grpc::CreateCustomChannel(address, CredentialsOf(options.tls), arguments);
  stubs->sessions = v1::SessionService::NewStub(stubs->channel);
  stubs->maps = v1::MapService::NewStub(stubs->channel);
  stubs->edits = v1::EditService::NewStub(stubs->channel);
  stubs->admin = v1::AdminService::NewStub(stubs->channel);
  stubs->access = v1::AccessService::NewStub(stubs->channel);
  stubs->localisation = v1::LocalisationService::NewStub(stubs->channel);
  stubs->events = v1::EventService::NewStub(stubs->channel);
  return stubs;
}

}  // namespace

absl::Status ToStatus(const grpc::Status& status) {
  // gRPC and absl share the canonical codes.
  return convert::WithDetails(
      absl::Status(static_cast<absl::StatusCode>(status.error_code()), status.error_message()),
      status.error_details());
}

void SetDeadline(double timeout_s, grpc::ClientContext& context) {
  context.set_deadline(std::chrono::system_clock::now() +
                       std::chrono::microseconds(static_cast<int64_t>(timeout_s * 1e6)));
}

absl::Status NotAgain(const absl::Status& status) {
  if (!absl::IsUnavailable(status)) return status;
  return absl::AbortedError(absl::StrCat("the link was lost half way: ", status.message()));
}

Client::Link::Link(const ClientOptions& options)
    : SessionLink(options), stubs_(Open(options, addresses().front(), ways() > 1)) {}

std::shared_ptr<Client::Link::Stubs> Client::Link::Get() {
  MutexLock lock(&mutex_);
  return stubs_;
}

void Client::Link::Renew(const std::shared_ptr<Stubs>& broken) {
  MutexLock lock(&mutex_);
  if (stubs_ != broken) return;
  current_ = (current_ + 1) % addresses().size();
  stubs_ = Open(options(), addresses()[current_], ways() > 1);
}

void Client::Link::Attach(grpc::ClientContext& context) const {
  if (!options().token.empty()) {
    context.AddMetadata("authorization", absl::StrCat("Bearer ", options().token));
  }
  if (!options().site.empty()) context.AddMetadata("isthmus-site", options().site);
}

absl::Status Client::Link::Once(double timeout_s, const Attempt& attempt) {
  const std::shared_ptr<Stubs> stubs = Get();
  grpc::ClientContext context;
  Attach(context);
  SetDeadline(timeout_s, context);
  const absl::Status status = ToStatus(attempt(*stubs, context));
  if (absl::IsUnavailable(status)) Renew(stubs);
  return status;
}

absl::Status Client::Link::Call(double timeout_s, const Attempt& attempt) {
  return Repeat(false, [&] { return Once(timeout_s, attempt); });
}

absl::Status Client::Link::CallOnce(double timeout_s, const Attempt& attempt) {
  const absl::Status reachable = Probe();
  return reachable.ok() ? Explain(Once(timeout_s, attempt)) : reachable;
}

absl::Status Client::Link::Probe() {
  return Call(options().call_timeout_s, [](Stubs& stubs, grpc::ClientContext& context) {
    v1::Token own;
    const grpc::Status status = stubs.access->GetOwnToken(&context, v1::GetOwnTokenRequest(), &own);
    // An older server's refusal is a sign of life, too.
    return status.error_code() == grpc::StatusCode::UNIMPLEMENTED ? grpc::Status::OK : status;
  });
}

}  // namespace isthmus::client
