// isthmus token: who may do what on a server.
#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>
#include <absl/time/clock.h>
#include <absl/time/time.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include "api/convert/access.h"
#include "client/console/age.h"
#include "client/console/command.h"
#include "client/console/exit_code.h"
#include "client/console/json.h"
#include "client/console/say.h"
#include "core/io/of_file.h"
#include "server/access/tokens.h"

namespace isthmus::cli {
namespace {

struct TokenOptions {
  ServerOptions server;
  std::string data;  // The map's folder; empty: a server is asked.
  std::string name, role, expires = "never";
  std::vector<std::string> robots, sites;
  bool json = false;
};

// The tokens of a server, or of a folder.
class TokenKeeper {
 public:
  static absl::StatusOr<TokenKeeper> Open(const TokenOptions& options) {
    TokenKeeper keeper;
    if (options.data.empty()) {
      auto client = Connect(options.server);
      if (!client.ok()) return client.status();
      keeper.client_ = *std::move(client);
    } else if (std::error_code error; !std::filesystem::is_directory(options.data, error)) {
      // One without tokens, of a server that is open to all, is not to be taken for one mistyped.
      return io::OfFile(absl::NotFoundError(absl::StrCat(
          "there is no folder ", options.data,
          ": give the folder of a map, or create it before the first start of its server")));
    } else {
      auto tokens = access::Tokens::Open(options.data);
      if (!tokens.ok()) return tokens.status();
      keeper.tokens_ = *std::move(tokens);
    }
    return keeper;
  }

  absl::StatusOr<NewAccessToken> Create(AccessToken wanted) {
    if (client_ != nullptr) return client_->CreateToken(wanted);
    if (wanted.sites.empty()) wanted.sites = access::SitesUnlessNamed(wanted.role, {"*"});
    return tokens_->Create(std::move(wanted));
  }
  absl::StatusOr<AccessToken> Revoke(const std::string& name) {
    return client_ != nullptr ? client_->RevokeToken(name) : tokens_->Revoke(name);
  }
  absl::StatusOr<std::vector<AccessToken>> List() {
    if (client_ != nullptr) return client_->ListTokens();
    return tokens_->List();
  }

 private:
  std::unique_ptr<client::Client> client_;
  std::unique_ptr<access::Tokens> tokens_;
};

absl::StatusOr<int64_t> ExpiryOf(const std::string& text) {
  if (text == "never") return 0;
  const std::optional<absl::Duration> age = ParseAge(text);
  // Nanoseconds since 1970 end in 2262.
  if (age && *age < absl::Hours(24 * 365 * 200)) return absl::ToUnixNanos(absl::Now() + *age);
  return absl::InvalidArgumentError(
      absl::StrCat("--expires ", text,
                   " is not a time: give 30s, 90m, 12h, 30d or 2w, counted from now, or never"));
}

std::string Day(int64_t ns, const char* none) {
  if (ns == 0) return none;
  return absl::FormatTime("%Y-%m-%d %H:%M", absl::FromUnixNanos(ns), absl::UTCTimeZone());
}

std::string StateOf(const AccessToken& token) {
  if (token.revoked_ns != 0) return "revoked";
  const bool expired = token.expires_ns != 0 && token.expires_ns <= absl::ToUnixNanos(absl::Now());
  return expired ? "expired" : "valid";
}

Json TokenJson(const AccessToken& token) {
  Json out = ToJson(convert::ToMessage(token));
  out["state"] = StateOf(token);
  return out;
}

// A robot's token is called as the robot, unless it is for several.
absl::StatusOr<AccessToken> Wanted(const TokenOptions& options) {
  AccessToken token;
  const auto role = access::ParseRole(options.role);
  if (!role.ok()) return role.status();
  const auto expires_ns = ExpiryOf(options.expires);
  if (!expires_ns.ok()) return expires_ns.status();
  token.name = options.name;
  if (token.name.empty() && options.robots.size() == 1 &&
      options.robots[0].find('*') == std::string::npos) {
    token.name = options.robots[0];
  }
  if (token.name.empty()) return absl::InvalidArgumentError("give the token a name: --name");
  token.role = *role;
  token.robots = options.robots;
  token.sites = options.sites;
  token.expires_ns = *expires_ns;
  return token;
}

int RunCreate(const TokenOptions& options) {
  auto wanted = Wanted(options);
  if (!wanted.ok()) return Fail(kUsage, wanted.status());
  auto keeper = TokenKeeper::Open(options);
  if (!keeper.ok()) return FailServer(keeper.status());
  const auto made = keeper->Create(*std::move(wanted));
  if (!made.ok()) return FailServer(made.status());
  if (options.json) {
    Print({{"token", TokenJson(made->token)}, {"secret", made->secret}});
    return kOk;
  }
  // The secret alone is on stdout, so that it may be sent into a file.
  Warn(
      "token %s (%s) was made for site %s; it expires: %s. This is its secret, which cannot be "
      "shown again:\n",
      made->token.name, access::RoleName(made->token.role), absl::StrJoin(made->token.sites, ", "),
      Day(made->token.expires_ns, "never"));
  std::puts(made->secret.c_str());  // The one secret that is to be shown.
  return kOk;
}

int RunRevoke(const TokenOptions& options) {
  auto keeper = TokenKeeper::Open(options);
  if (!keeper.ok()) return FailServer(keeper.status());
  const auto revoked = keeper->Revoke(options.name);
  if (!revoked.ok()) return FailServer(revoked.status());
  if (options.json) {
    Print({{"token", TokenJson(*revoked)}});
  } else {
    Say("token %s is revoked: calls with it fail, and those under way end in seconds\n",
        revoked->name);
  }
  return kOk;
}

int RunTokenList(const TokenOptions& options) {
  auto keeper = TokenKeeper::Open(options);
  if (!keeper.ok()) return FailServer(keeper.status());
  const auto tokens = keeper->List();
  if (!tokens.ok()) return FailServer(tokens.status());
  if (options.json) {
    Json list = Json::array();
    for (const AccessToken& token : *tokens) list.push_back(TokenJson(token));
    Print({{"tokens", list}});
    return kOk;
  }
  if (tokens->empty()) Say("no tokens: everybody who reaches the server may do everything\n");
  for (const AccessToken& token : *tokens) {
    Say("%-20s %-8s %-8s made %s  expires %-16s  sites %s%s%s\n", token.name,
        access::RoleName(token.role), StateOf(token), Day(token.created_ns, "-"),
        Day(token.expires_ns, "never"), absl::StrJoin(token.sites, ","),
        token.robots.empty() ? "" : "  robots ", absl::StrJoin(token.robots, ","));
  }
  return kOk;
}

std::shared_ptr<TokenOptions> AddTokenCommand(CLI::App& token, Action& action, const char* name,
                                              const char* what, int (*run)(const TokenOptions&)) {
  auto options = std::make_shared<TokenOptions>();
  CLI::App* command = token.add_subcommand(name, what);
  AddSitelessOptions(*command, options->server);
  command->add_option("--data", options->data,
                      "Change the tokens in this map folder without a server; a server running on "
                      "it sees the change");
  command->add_flag("--json", options->json, "As JSON");
  command->callback([options, run, command, &action] {
    // An address from the environment is no contradiction: it is the usual one.
    const char* const usual = std::getenv("ISTHMUS_SERVER");
    const bool is_usual = usual != nullptr && options->server.address == usual;
    if (!options->data.empty() && command->count("--server") > 0 && !is_usual) {
      throw CLI::ExcludesError("--data", "--server");
    }
    action = [options, run] { return run(*options); };
  });
  return options;
}

}  // namespace

void AddToken(CLI::App& app, Action& action) {
  CLI::App* token = app.add_subcommand("token", "Make, list and revoke tokens, which give rights");
  token->require_subcommand(1);
  const auto made = AddTokenCommand(
      *token, action, "create", "Make a token; its secret is printed only this once", &RunCreate);
  CLI::App* create = token->get_subcommand("create");
  create->add_option("--role", made->role, "robot, reader, operator or admin")->required();
  create->add_option("--name", made->name,
                     "Name of the token; for a robot's token the robot's name unless given");
  create->add_option(
      "--robot", made->robots,
      "Robots whose scans it may send, * for any characters; other roles may have robots too");
  create->add_option("--site", made->sites,
                     "Sites for which the token holds; without it the default site");
  create
      ->add_option("--expires", made->expires,
                   "Lifetime from now: 30s, 90m, 12h, 30d, 2w; or never")
      ->capture_default_str();
  AddTokenCommand(*token, action, "list", "List all tokens, without their secrets", &RunTokenList);
  const auto revoked = AddTokenCommand(*token, action, "revoke", "Revoke a token", &RunRevoke);
  token->get_subcommand("revoke")->add_option("NAME", revoked->name)->required();
}

}  // namespace isthmus::cli
