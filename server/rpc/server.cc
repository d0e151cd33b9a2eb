#include "server/rpc/server.h"

#include <absl/strings/str_cat.h>
#include <absl/time/clock.h>
#include <google/protobuf/stubs/logging.h>
#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/grpcpp.h>
#include <grpcpp/health_check_service_interface.h>
#include <grpcpp/resource_quota.h>
#include <sys/resource.h>

#include <algorithm>
#include <atomic>
#include <climits>
#include <utility>
#include <vector>

#include "core/address.h"
#include "core/site_name.h"
#include "server/rpc/closed_reflection.h"
#include "server/rpc/gate.h"
#include "server/rpc/health_watch.h"
#include "server/rpc/listener.h"
#include "server/rpc/services.h"
#include "server/rpc/streams/call_watch.h"
#include "server/rpc/tls.h"

namespace isthmus::rpc {
namespace {

// Reflection and health are switched on for every server of the process, before the first is built.
void EnablePlugins() {
  [[maybe_unused]] static const bool enabled = [] {
    grpc::EnableDefaultHealthCheckService(true);
    grpc::reflection::InitProtoReflectionServerBuilderPlugin();
    google::protobuf::SetLogHandler(nullptr);  // A line of stderr for whatever strangers send.
    return true;
  }();
}

// For statuses to leave: a socket's buffer takes them at once.
constexpr std::chrono::milliseconds kLastWords{100};

// Files that connections leave to everything else, by what the process may have open: databases,
// files of maps, what comes in by other ways.
constexpr int kFilesForOthers = 64, kSmallestShare = 4;

Listener::Limits LimitsOf(const ServerOptions& options) {
  Listener::Limits limits = {static_cast<size_t>(options.max_connections), INT_MAX};
  rlimit limit = {};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return limits;
  const auto files = static_cast<int>(std::min<rlim_t>(limit.rlim_cur, INT_MAX));
  limits.files = files - std::min(kFilesForOthers, files / kSmallestShare);
  return limits;
}

std::string WithPort(const std::string& listen, int port) {
  const size_t colon = listen.rfind(':');
  if (colon == std::string::npos || listen.rfind("unix", 0) == 0) return listen;
  return absl::StrCat(listen.substr(0, colon), ":", port);
}

std::vector<std::unique_ptr<Site>> SitesOf(const std::vector<ServedSite>& served,
                                           const ServerOptions& options) {
  std::vector<std::unique_ptr<Site>> sites;
  sites.reserve(served.size());
  for (const ServedSite& site : served) {
    sites.push_back(std::make_unique<Site>(
        site.name, site.pipeline, site.backup,
        AckWindow::Limits{options.scan_window, options.streams.all_bytes / kStreamsAtTheirMost},
        site.uploads_folder, options.max_staged_bytes));
  }
  return sites;
}

Gate::Options GateOptions(const std::vector<std::unique_ptr<Site>>& sites, CallLimits* limits,
                          const ServerOptions& options) {
  Gate::Options gate;
  gate.limits = limits;
  for (const std::unique_ptr<Site>& site : sites) gate.sites.push_back(site.get());
  gate.tokens = options.tokens;
  gate.require_token = options.require_token;
  gate.review_interval = options.token_review_interval;
  gate.on_failed_call = options.on_failed_call;
  gate.on_ended_call = options.on_ended_call;
  return gate;
}

std::vector<std::unique_ptr<grpc::Service>> MakeServices(const ServiceParts& parts) {
  std::vector<std::unique_ptr<grpc::Service>> services;
  for (const auto make : {MakeSessionService, MakeMapService, MakeEditService, MakeEventService,
                          MakeLocalisationService, MakeAdminService, MakeAccessService}) {
    services.push_back(make(parts));
  }
  return services;
}

}  // namespace

struct RpcServer::State {
  State(const std::vector<ServedSite>& served, const ServerOptions& options)
      : sites(SitesOf(served, options)),
        calls(options.calls),
        gate(GateOptions(sites, &calls, options)),
        host(&gate, options.streams),
        services(
            MakeServices({gate, host, options.tokens, options.max_submap_bytes, web_address})) {}

  const std::vector<std::unique_ptr<Site>> sites;
  CallLimits calls;
  Gate gate;
  StreamHost host;
  WebAddress web_address;
  const std::vector<std::unique_ptr<grpc::Service>> services;
  int port = 0;
  std::string address;
  std::atomic<bool> shut_down = false;
  std::unique_ptr<WatchedKeys> keys;     // Null: plain text.
  std::unique_ptr<grpc::Server> server;  // So late that it goes before its services.
  std::unique_ptr<grpc::experimental::ExternalConnectionAcceptor> connections;
  std::unique_ptr<Listener> listener;   // Null: gRPC listens, at a socket that is a file.
  std::unique_ptr<HealthWatch> health;  // Tells the server.

  // Before the server is built.
  absl::Status Listen(const ServerOptions& options,
                      const std::shared_ptr<grpc::ServerCredentials>& credentials,
                      grpc::ServerBuilder* builder) {
    if (options.listen.starts_with("unix")) {
      builder->AddListeningPort(options.listen, credentials);
      return absl::OkStatus();
    }
    absl::StatusOr<std::unique_ptr<Listener>> opened = Listener::Open(options.listen);
    if (!opened.ok()) return opened.status();
    listener = *std::move(opened);
    using Type = grpc::ServerBuilder::experimental_type::ExternalConnectionType;
    connections = builder->experimental().AddExternalConnectionAcceptor(Type::FROM_FD, credentials);
    return absl::OkStatus();
  }
};

absl::StatusOr<std::unique_ptr<RpcServer>> RpcServer::Start(server::Pipeline* pipeline,
                                                            const ServerOptions& options) {
  return Start({{kDefaultSite, pipeline, options.backup, options.uploads_folder}}, options);
}

absl::StatusOr<std::unique_ptr<RpcServer>> RpcServer::Start(const std::vector<ServedSite>& sites,
                                                            const ServerOptions& options) {
  if (absl::Status status = CheckAddress(options.listen, PortZero::kAnyFreeOne); !status.ok()) {
    return status;
  }
  if (absl::Status status = CheckListening(options); !status.ok()) return status;
  auto keys = OpenKeys(options.tls);
  if (!keys.ok()) return keys.status();
  EnablePlugins();
  auto state = std::make_unique<State>(sites, options);
  state->keys = *std::move(keys);
  grpc::ServerBuilder builder;
  // A robot out of reach is noticed within a minute. Robots may probe every few seconds, so that
  // they notice a dead radio link as soon.
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIME_MS, 30'000);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 20'000);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 1);
  builder.AddChannelArgument(GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS, 1'000);
  // A connection that says nothing is closed, and one without calls after a while; clients open
  // another when they have something to ask.
  builder.AddChannelArgument(GRPC_ARG_SERVER_HANDSHAKE_TIMEOUT_MS, 10'000);
  builder.AddChannelArgument(GRPC_ARG_MAX_CONNECTION_IDLE_MS, 600'000);
  builder.AddChannelArgument(GRPC_ARG_MAX_CONCURRENT_STREAMS, kCallsPerConnection);
  // Now and then gRPC 1.51 fails to wake a thread when it shuts down, and waits for it to look by
  // itself: after 10 s unless told otherwise.
  builder.SetSyncServerOption(grpc::ServerBuilder::CQ_TIMEOUT_MSEC, 500);
  builder.SetMaxReceiveMessageSize(options.max_receive_bytes);
  grpc::ResourceQuota quota("isthmus");
  quota.SetMaxThreads(options.max_threads);
  quota.Resize(options.streams.all_bytes + kConnectionSpareBytes);
  builder.SetResourceQuota(quota);
  std::vector<std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface>> watch;
  watch.push_back(
      std::make_unique<CallWatchFactory>(&state->host.watchdog, options.streams.progress));
  watch.push_back(CloseReflection(&state->gate));
  builder.experimental().SetInterceptorCreators(std::move(watch));
  if (absl::Status status =
          state->Listen(options, MakeServerCredentials(state->keys.get()), &builder);
      !status.ok()) {
    return status;
  }
  for (const auto& service : state->services) builder.RegisterService(service.get());
  state->server = builder.BuildAndStart();
  if (state->server == nullptr) {
    return absl::UnavailableError(
        absl::StrCat("cannot listen at ", options.listen, ": name another address"));
  }
  if (state->listener != nullptr) {
    state->port = state->listener->port();
    state->listener->Start(
        LimitsOf(options), [to = state->connections.get()](int listening, int socket) {
          grpc::experimental::ExternalConnectionAcceptor::NewConnectionParameters connection;
          connection.listener_fd = listening;
          connection.fd = socket;
          to->HandleNewConnection(&connection);
        });
  }
  state->address = WithPort(options.listen, state->port);
  grpc::HealthCheckServiceInterface* health = state->server->GetHealthCheckService();
  state->health = std::make_unique<HealthWatch>(state->gate.sites(), options.health_interval,
                                                [health](const std::string& service, bool serves) {
                                                  health->SetServingStatus(service, serves);
                                                });
  return std::unique_ptr<RpcServer>(new RpcServer(std::move(state)));
}

RpcServer::RpcServer(std::unique_ptr<State> state) : state_(std::move(state)) {}

RpcServer::~RpcServer() { Shutdown(std::chrono::milliseconds(0)); }

int RpcServer::port() const { return state_->port; }

std::string RpcServer::address() const { return state_->address; }

std::shared_ptr<grpc::Channel> RpcServer::InProcessChannel() {
  grpc::ChannelArguments arguments;
  arguments.SetMaxReceiveMessageSize(-1);  // From ourselves.
  return state_->server->InProcessChannel(arguments);
}

Gate& RpcServer::gate() { return state_->gate; }

void RpcServer::TellWebAddress(const std::string& address) { state_->web_address.Set(address); }

void RpcServer::Shutdown(std::chrono::milliseconds grace) {
  if (state_->shut_down.exchange(true)) return;
  if (state_->listener != nullptr) state_->listener->Stop();
  state_->server->GetHealthCheckService()->Shutdown();
  state_->health = nullptr;  // No service serves after that, whatever it says.
  // Not left to gRPC, which waits for clients to close their connections, too, and idle ones do
  // that when they please.
  state_->calls.Stop();
  state_->host.StopAll();
  state_->calls.WaitUntilIdle(absl::Now() + absl::FromChrono(grace));
  // The last statuses are on their way.
  state_->server->Shutdown(std::chrono::system_clock::now() + std::min(grace, kLastWords));
}

}  // namespace isthmus::rpc
