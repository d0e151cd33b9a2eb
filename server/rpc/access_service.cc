// Tokens, made and revoked by administrators. What each method returns and fails with is said in
// api/isthmus/v1/access_service.proto.
#include <absl/strings/str_cat.h>

#include <algorithm>
#include <string>
#include <utility>

#include "api/convert/access.h"
#include "isthmus/v1/access_service.grpc.pb.h"
#include "server/access/token_text.h"
#include "server/rpc/responses.h"
#include "server/rpc/services.h"

namespace isthmus::rpc {
namespace {

absl::Status NoTokens() {
  return absl::UnimplementedError("this server keeps no tokens: it accepts every caller");
}

// A caller for one site cannot make, see or revoke tokens that count for another.
bool SeesAllSitesOf(const access::Caller& caller, const AccessToken& token) {
  return std::all_of(token.sites.begin(), token.sites.end(),
                     [&](const std::string& site) { return caller.MaySee(site); });
}

class AccessService final : public v1::AccessService::Service {
 public:
  explicit AccessService(const ServiceParts& parts) : gate_(parts.gate), tokens_(parts.tokens) {}

  grpc::Status CreateToken(grpc::ServerContext* context, const v1::CreateTokenRequest* request,
                           v1::CreateTokenResponse* response) override {
    return gate_.Serve(context, *request, "CreateToken", [&](const Call& call) -> absl::Status {
      if (tokens_ == nullptr) return NoTokens();
      auto wanted = convert::FromMessage(request->token());
      if (!wanted.ok()) return wanted.status();
      if (wanted->sites.empty()) {
        wanted->sites = access::SitesUnlessNamed(wanted->role, call.caller.sites);
      }
      if (!SeesAllSitesOf(call.caller, *wanted)) {
        return absl::PermissionDeniedError(
            "a token can be made only for sites that your own token is for: name others");
      }
      const auto made = tokens_->Create(*std::move(wanted));
      if (made.ok()) {
        NoteToken(EventKind::kTokenCreated, made->token, call);
        *response->mutable_token() = convert::ToMessage(made->token);
        response->set_secret(made->secret);
      }
      return made.status();
    });
  }

  grpc::Status ListTokens(grpc::ServerContext* context, const v1::ListTokensRequest* request,
                          grpc::ServerWriter<v1::ListTokensResponse>* writer) override {
    return gate_.Serve(context, *request, "ListTokens", [&](const Call& call) -> absl::Status {
      if (tokens_ == nullptr) return NoTokens();
      ListEmitter<v1::ListTokensResponse> list(call, {}, writer);
      for (const AccessToken& token : tokens_->List()) {
        if (!SeesAllSitesOf(call.caller, token)) continue;
        list.Add(&v1::ListTokensResponse::mutable_tokens, convert::ToMessage(token));
      }
      return list.Finish();
    });
  }

  grpc::Status RevokeToken(grpc::ServerContext* context, const v1::RevokeTokenRequest* request,
                           v1::Token* response) override {
    return gate_.Serve(context, *request, "RevokeToken", [&](const Call& call) -> absl::Status {
      if (tokens_ == nullptr) return NoTokens();
      const auto may_revoke = [&](const AccessToken& token) {
        return SeesAllSitesOf(call.caller, token);
      };
      const auto revoked = tokens_->Revoke(request->name(), may_revoke);
      if (revoked.ok()) {
        NoteToken(EventKind::kTokenRevoked, *revoked, call);
        *response = convert::ToMessage(*revoked);
      }
      return revoked.status();
    });
  }

  grpc::Status GetOwnToken(grpc::ServerContext* context, const v1::GetOwnTokenRequest* request,
                           v1::Token* response) override {
    return gate_.Serve(context, *request, "GetOwnToken", [&](const Call& call) -> absl::Status {
      const access::Caller& caller = call.caller;
      *response =
          convert::ToMessage(AccessToken{caller.token, caller.role, caller.robots, caller.sites});
      if (tokens_ == nullptr) return absl::OkStatus();
      for (const AccessToken& token : tokens_->List()) {
        if (token.name == caller.token) *response = convert::ToMessage(token);
      }
      return absl::OkStatus();
    });
  }

 private:
  // In the logs of the sites that the token is for.
  void NoteToken(EventKind kind, const AccessToken& token, const Call& call) const {
    Event event;
    event.kind = kind;
    event.actor = call.actor();
    event.text = absl::StrCat("token ", token.name, " (", access::RoleName(token.role), ") ",
                              kind == EventKind::kTokenCreated ? "made" : "revoked");
    access::Caller its_caller;
    its_caller.sites = token.sites;
    for (Site* site : gate_.sites()) {
      if (its_caller.MaySee(site->name)) site->pipeline.events().Note(event);
    }
  }

  Gate& gate_;
  access::Tokens* const tokens_;
};

}  // namespace

std::unique_ptr<grpc::Service> MakeAccessService(const ServiceParts& parts) {
  return std::make_unique<AccessService>(parts);
}

}  // namespace isthmus::rpc
