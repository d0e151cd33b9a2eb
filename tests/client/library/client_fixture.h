// A client and a server on a real socket, behind it a pipeline that answers what the test says.
#pragma once

#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

#include "client/library/client.h"
#include "tests/server/rpc/rpc_fixture.h"

namespace isthmus::client {

class ClientTest : public rpc::RpcTest {
 protected:
  ClientTest() {
    auto client = Client::Connect({.address = server_->address()});
    if (!client.ok()) throw std::runtime_error(std::string(client.status().message()));
    client_ = *std::move(client);
  }

  std::unique_ptr<Client> client_;
};

}  // namespace isthmus::client
