#include "server/web/web_server.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/strip.h>

#include <utility>

#include "core/address.h"
#include "core/plain_text.h"
#include "server/web/answers.h"
#include "server/web/autoware.h"
#include "server/web/caller.h"
#include "server/web/floors.h"
#include "server/web/gateway.h"
#include "server/web/limits.h"
#include "server/web/login.h"
#include "server/web/map_files.h"
#include "server/web/stream_slots.h"
#include "server/web/tiles.h"
#include "server/web/trajectories.h"
#include "server/web/vehicle_maps.h"

namespace isthmus::web {
namespace {

constexpr char kSetting[] = "web.listen";

// Headers that limit a page of ours, above all one that somebody else's name or frame brings about.
constexpr std::pair<const char*, const char*> kForAll[] = {
    {"Content-Security-Policy",
     "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; "
     "connect-src 'self'; worker-src 'self' blob:; base-uri 'none'; form-action 'none'; "
     "frame-ancestors 'none'"},
    {"X-Content-Type-Options", "nosniff"},
    {"Referrer-Policy", "no-referrer"},
    {"Cross-Origin-Resource-Policy", "same-origin"},
    {"Cross-Origin-Opener-Policy", "same-origin"}};

http::Response AnswerHealth(const http::Request& request) {
  if (request.method != "GET" && request.method != "HEAD") return WrongMethod("GET, HEAD");
  http::Response response = http::Text(HttpCode(absl::StatusCode::kOk), "ok\n");
  response.Set("Cache-Control", "no-store");
  return response;
}

class HttpWebServer final : public WebServer {
 public:
  HttpWebServer(const WebOptions& options, rpc::RpcServer& server, const Assets& assets)
      : options_(options),
        channel_(server.InProcessChannel()),
        gate_(server.gate()),
        assets_(assets),
        slots_(kWebStreams, kWebStreamsOfOne),
        floor_slots_(kFloorsAtOnce, kFloorsAtOnce),
        gateway_(channel_, &slots_) {}

  absl::Status Listen();
  std::string url() const override {
    return absl::StrCat(options_.tls.key.empty() ? "http://" : "https://", listener_->address());
  }

 private:
  http::Response Answer(const http::Request& request);
  http::Response Route(const http::Request& request);

  const WebOptions options_;
  const std::shared_ptr<grpc::Channel> channel_;
  rpc::Gate& gate_;
  const Assets& assets_;
  StreamSlots slots_, floor_slots_;
  const Gateway gateway_;
  std::unique_ptr<http::Listener> listener_;  // So late that it goes first.
};

absl::Status HttpWebServer::Listen() {
  http::ListenerOptions options;
  options.listen = options_.listen;
  options.setting = kSetting;
  options.tls = options_.tls;
  options.connections = kConnections;
  options.connections_per_address = kConnectionsPerAddress;
  options.max_body = kBodyBytes;
  auto listener = http::Listener::Start(
      options, [this](const http::Request& request) { return Answer(request); });
  if (!listener.ok()) return listener.status();
  listener_ = *std::move(listener);
  return absl::OkStatus();
}

http::Response HttpWebServer::Answer(const http::Request& request) {
  http::Response response = Route(request);
  for (const auto& [name, value] : kForAll) response.Set(name, value);
  return response;
}

// Checks that the address is text: names in it travel on in messages, which hold UTF-8 alone.
absl::Status CheckAddressText(const http::Request& request) {
  bool is_text = IsUtf8(request.path);
  for (const auto& [name, value] : request.query) {
    is_text = is_text && IsUtf8(name) && IsUtf8(value);
  }
  if (is_text) return absl::OkStatus();
  return absl::InvalidArgumentError("the address, without its escapes, is not text in UTF-8");
}

http::Response HttpWebServer::Route(const http::Request& request) {
  if (!IsOurHost(request, options_.hosts)) {
    return ErrorAnswer(421, absl::FailedPreconditionError(
                                "this server does not know itself by that name: ask for it "
                                "by its address, or have it name itself so in web.hosts"));
  }
  if (absl::Status status = CheckAddressText(request); !status.ok()) return ErrorAnswer(status);
  absl::string_view rest = request.path;
  if (absl::ConsumePrefix(&rest, "/rpc/")) return gateway_.Answer(request, rest);
  if (absl::ConsumePrefix(&rest, "/tiles/")) return AnswerTile(request, channel_);
  if (absl::ConsumePrefix(&rest, "/export/"))
    return AnswerMapFile(request, gate_, channel_, &slots_);
  if (absl::ConsumePrefix(&rest, "/autoware/")) return AnswerAutoware(request, gate_, &slots_);
  if (absl::ConsumePrefix(&rest, "/floors/")) {
    return AnswerFloor(request, gate_, &floor_slots_);
  }
  if (absl::ConsumePrefix(&rest, "/trajectories/")) return AnswerTrajectory(request, gate_);
  if (rest == "/trajectories.geojson") return AnswerTrajectoriesGeoJson(request, gate_);
  if (absl::ConsumePrefix(&rest, "/vda5050/")) return AnswerDownloadMap(request, gate_);
  if (rest == "/login") return LogIn(request, channel_);
  if (rest == "/logout") return LogOut(request);
  if (rest == "/healthz") return AnswerHealth(request);
  return AnswerAsset(request, assets_);
}

}  // namespace

absl::Status CheckListening(const WebOptions& options) {
  if (options.listen.empty()) return absl::OkStatus();
  if (absl::Status status = http::CheckTcpAddress(kSetting, options.listen); !status.ok()) {
    return status;
  }
  if (options.insecure || !options.tls.key.empty() || IsThisMachine(options.listen)) {
    return absl::OkStatus();
  }
  return absl::FailedPreconditionError(absl::StrCat(
      "at ", options.listen,
      " whoever reaches this machine could read along, tokens too: serve with TLS "
      "(network.tls_certificate and tls_key; `isthmus certs init` makes them), listen at 127.0.0.1 "
      "(web.listen), or set web.insecure: true where the network itself is safe"));
}

absl::StatusOr<std::unique_ptr<WebServer>> WebServer::Start(const WebOptions& options,
                                                            rpc::RpcServer& server,
                                                            const Assets& assets) {
  if (absl::Status status = CheckListening(options); !status.ok()) return status;
  auto web = std::make_unique<HttpWebServer>(options, server, assets);
  if (absl::Status status = web->Listen(); !status.ok()) return status;
  return web;
}

}  // namespace isthmus::web
