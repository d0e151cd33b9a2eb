#include "client/library/link.h"

#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>
#include <grpcpp/create_channel.h>
#include <grpcpp/security/credentials.h>
#include <grpcpp/support/channel_arguments.h>

#include <chrono>
#include <thread>

#include "client/library/convert.h"

namespace isthmus::client {
namespace {

// Above anything the server puts into one message: graphs and lists of submaps are unary.
constexpr int kMaxReceivedBytes = 64 << 20;
// A radio link that is dead is noticed within the sum of these; the server permits it. One that is
// merely slow answers a ping behind the scans that are under way.
constexpr int kPingEveryMs = 5'000, kPingTimeoutMs = 10'000;
constexpr char kSought[] = "cannot reach isthmus-server at ";

std::shared_ptr<Client::Link::Stubs> Open(const std::string& address) {
  grpc::ChannelArguments arguments;
  arguments.SetMaxReceiveMessageSize(kMaxReceivedBytes);
  arguments.SetMaxSendMessageSize(-1);  // The server's own limit decides, and says so.
  // Not shared with other channels to the address, so that a new channel tries at once.
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, kPingEveryMs);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, kPingTimeoutMs);
  arguments.SetInt(GRPC_ARG_HTTP2_MAX_PINGS_WITHOUT_DATA, 0);  // No limit.
  auto stubs = std::make_shared<Client::Link::Stubs>();
  stubs->channel =
      grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), arguments);
  stubs->sessions = v1::SessionService::NewStub(stubs->channel);
  stubs->maps = v1::MapService::NewStub(stubs->channel);
  stubs->matches = v1::MatchService::NewStub(stubs->channel);
  stubs->graph = v1::GraphService::NewStub(stubs->channel);
  stubs->admin = v1::AdminService::NewStub(stubs->channel);
  return stubs;
}

}  // namespace

absl::Status NotAgain(const absl::Status& status) {
  if (!absl::IsUnavailable(status)) return status;
  return absl::AbortedError(absl::StrCat("the link was lost half way: ", status.message()));
}

Client::Link::Link(const ClientOptions& options)
    : options_(options), stubs_(Open(options.address)) {}

std::shared_ptr<Client::Link::Stubs> Client::Link::Get() {
  MutexLock lock(&mutex_);
  return stubs_;
}

void Client::Link::Renew(const std::shared_ptr<Stubs>& broken) {
  MutexLock lock(&mutex_);
  if (stubs_ == broken) stubs_ = Open(options_.address);
}

absl::Status Client::Link::Once(double timeout_s, const Attempt& attempt) {
  const std::shared_ptr<Stubs> stubs = Get();
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() +
                       std::chrono::microseconds(static_cast<int64_t>(timeout_s * 1e6)));
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
  return Call(options_.call_timeout_s, [](Stubs& stubs, grpc::ClientContext& context) {
    v1::MapInfo info;
    return stubs.maps->GetMapInfo(&context, v1::GetMapInfoRequest(), &info);
  });
}

absl::Status Client::Link::Repeat(bool also_data_loss,
                                  const std::function<absl::Status()>& attempt) {
  Backoff backoff = NewBackoff();
  for (;;) {
    const absl::Status status = attempt();
    const bool again = absl::IsUnavailable(status) || (also_data_loss && absl::IsDataLoss(status));
    if (!again) return status;
    const std::optional<double> delay = backoff.Next();
    if (!delay) return Explain(status);
    Sleep(*delay);
  }
}

absl::Status Client::Link::Explain(const absl::Status& status) const {
  if (!absl::IsUnavailable(status) || absl::StartsWith(status.message(), kSought)) return status;
  return absl::UnavailableError(
      absl::StrCat(kSought, options_.address, ": is it running? Start it with `isthmus-server ",
                   "--data DIR --listen ", options_.address, "` (", status.message(), ")"));
}

void Client::Link::Sleep(double seconds) const {
  if (options_.sleep) return options_.sleep(seconds);
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}

}  // namespace isthmus::client
