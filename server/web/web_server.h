// The server's side of browsers: the API, tiles and files of the map, and the viewer, over HTTP.
#pragma once

#include <absl/status/statusor.h>

#include <memory>
#include <string>

#include "server/rpc/server.h"
#include "server/web/asset.h"
#include "server/web/web_options.h"

namespace isthmus::web {

// docs/web.md lists the addresses. Thread safe.
class WebServer {
 public:
  // Serves until it is destroyed, which cuts off answers under way. `server`, which has the
  // services and the gate, must not shut down before; `assets` must outlive it. Errors of
  // CheckListening and http::Listener::Start.
  static absl::StatusOr<std::unique_ptr<WebServer>> Start(const WebOptions& options,
                                                          rpc::RpcServer& server,
                                                          const Assets& assets = ViewerAssets());
  virtual ~WebServer() = default;

  // "https://host:port", as it listens.
  virtual std::string url() const = 0;
};

}  // namespace isthmus::web
