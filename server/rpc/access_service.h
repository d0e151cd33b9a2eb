// Tokens, made and revoked by administrators. What each method returns and fails with is said in
// api/isthmus/v1/access_service.proto.
#pragma once

#include <grpcpp/server_context.h>
#include <grpcpp/support/status.h>
#include <grpcpp/support/sync_stream.h>

#include "isthmus/v1/access_service.grpc.pb.h"
#include "server/access/tokens.h"
#include "server/rpc/gate.h"

namespace isthmus::rpc {

// Thread safe. Whatever it is given must outlive it; the tokens may be null.
class AccessService final : public v1::AccessService::Service {
 public:
  AccessService(Gate* gate, access::Tokens* tokens) : gate_(*gate), tokens_(tokens) {}

  grpc::Status CreateToken(grpc::ServerContext* context, const v1::CreateTokenRequest* request,
                           v1::CreateTokenResponse* response) override;
  grpc::Status ListTokens(grpc::ServerContext* context, const v1::ListTokensRequest* request,
                          grpc::ServerWriter<v1::ListTokensResponse>* writer) override;
  grpc::Status RevokeToken(grpc::ServerContext* context, const v1::RevokeTokenRequest* request,
                           v1::Token* response) override;
  grpc::Status GetOwnToken(grpc::ServerContext* context, const v1::GetOwnTokenRequest* request,
                           v1::Token* response) override;

 private:
  // In the logs of the sites that the token is for.
  void NoteToken(EventKind kind, const AccessToken& token, const Call& call) const;

  Gate& gate_;
  access::Tokens* const tokens_;
};

}  // namespace isthmus::rpc
