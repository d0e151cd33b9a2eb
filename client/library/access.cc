// The part of Client that makes and revokes tokens.
#include "api/convert/access.h"

#include "client/library/client.h"
#include "client/library/link.h"
#include "client/library/list_stream.h"

namespace isthmus::client {

using Stubs = Client::Link::Stubs;

absl::StatusOr<NewAccessToken> Client::CreateToken(const AccessToken& wanted) {
  v1::CreateTokenRequest request;
  *request.mutable_token() = convert::ToMessage(wanted);
  v1::CreateTokenResponse response;
  const absl::Status status = link_->CallOnce(
      link_->options().call_timeout_s, [&](Stubs& stubs, grpc::ClientContext& context) {
        return stubs.access->CreateToken(&context, request, &response);
      });
  if (!status.ok()) return status;
  auto token = convert::FromMessage(response.token());
  if (!token.ok()) return token.status();
  return NewAccessToken{*std::move(token), response.secret()};
}

absl::StatusOr<AccessToken> Client::RevokeToken(const std::string& name) {
  v1::RevokeTokenRequest request;
  request.set_name(name);
  v1::Token response;
  // May be repeated: revoking twice is revoking once.
  const absl::Status status =
      link_->Call(link_->options().call_timeout_s, [&](Stubs& stubs, grpc::ClientContext& context) {
        return stubs.access->RevokeToken(&context, request, &response);
      });
  if (!status.ok()) return status;
  return convert::FromMessage(response);
}

absl::StatusOr<std::vector<AccessToken>> Client::ListTokens() {
  const auto open = [](Stubs& stubs, grpc::ClientContext& context) {
    return stubs.access->ListTokens(&context, v1::ListTokensRequest());
  };
  const auto add = [](const v1::ListTokensResponse& part, std::vector<AccessToken>& tokens) {
    for (const v1::Token& message : part.tokens()) {
      // One of a role that only a newer server knows cannot be shown.
      if (auto token = convert::FromMessage(message); token.ok()) {
        tokens.push_back(*std::move(token));
      }
    }
  };
  return ReadList<std::vector<AccessToken>, v1::ListTokensResponse>(*link_, open, add);
}

}  // namespace isthmus::client
