#include "server/access/tokens.h"

#include <absl/strings/escaping.h>
#include <absl/strings/str_cat.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "core/io/secret.h"
#include "core/io/sha256.h"
#include "core/nanoseconds.h"
#include "core/plain_text.h"
#include "core/site_name.h"
#include "server/access/caller.h"
#include "server/access/limits.h"

namespace isthmus::access {
namespace {

constexpr char kAskAgain[] = "ask an administrator for a new one (`isthmus token create`)";

// Stamps are kept to the second: an end never becomes an earlier one by that.
int64_t SecondFrom(int64_t ns) { return (ns + kNsPerSecond - 1) / kNsPerSecond * kNsPerSecond; }

std::string HashOf(absl::string_view secret) { return io::Sha256(secret.data(), secret.size()); }

absl::StatusOr<std::string> NewSecret() {
  const absl::StatusOr<std::string> bytes = io::RandomBytes(kSecretBytes);
  if (!bytes.ok()) return bytes.status();
  return absl::StrCat(kSecretPrefix, absl::WebSafeBase64Escape(*bytes));
}

const StoredToken* Named(const std::vector<StoredToken>& tokens, const std::string& name) {
  const auto found = std::find_if(tokens.begin(), tokens.end(),
                                  [&](const StoredToken& t) { return t.token.name == name; });
  return found == tokens.end() ? nullptr : &*found;
}

// Removes the token that was revoked first if the file is full; its name may be used again.
absl::Status MakeRoom(std::vector<StoredToken>& tokens) {
  if (tokens.size() < kMaxTokens) return absl::OkStatus();
  auto oldest = tokens.end();
  for (auto token = tokens.begin(); token != tokens.end(); ++token) {
    const int64_t revoked_ns = token->token.revoked_ns;
    if (revoked_ns == 0) continue;
    if (oldest == tokens.end() || revoked_ns < oldest->token.revoked_ns) oldest = token;
  }
  if (oldest == tokens.end()) {
    return absl::ResourceExhaustedError(
        absl::StrCat("there are ", kMaxTokens, " tokens: revoke one that is no longer used"));
  }
  tokens.erase(oldest);
  return absl::OkStatus();
}

}  // namespace

std::vector<std::string> SitesUnlessNamed(AccessRole role, std::vector<std::string> of_maker) {
  if (role == AccessRole::kAdmin) return of_maker;
  return {kDefaultSite};
}

absl::StatusOr<std::unique_ptr<Tokens>> Tokens::Open(const std::string& folder,
                                                     OnProblem on_problem, const Clock& clock) {
  std::unique_ptr<Tokens> tokens(new Tokens(folder, std::move(on_problem), clock));
  MutexLock lock(&tokens->mutex_);
  if (absl::Status status = tokens->Load(); !status.ok()) return status;
  return tokens;
}

absl::Status Tokens::Load() {
  // Before it is read: a change in between is seen by the next look.
  version_ = file_.version();
  auto read = file_.Read();
  if (!read.ok()) return read.status();
  tokens_ = std::make_shared<const std::vector<StoredToken>>(*std::move(read));
  return absl::OkStatus();
}

Tokens::Snapshot Tokens::Newest() {
  MutexLock lock(&mutex_);
  const int64_t now_ns = clock_.NowNs();
  if (now_ns - looked_ns_ < kLookAgainNs && now_ns >= looked_ns_) return tokens_;
  looked_ns_ = now_ns;
  const TokenFile::Version version = file_.version();
  if (version == version_) return tokens_;
  if (version == TokenFile::Version() && !tokens_->empty()) {
    version_ = version;
    if (on_problem_)
      on_problem_(absl::StrCat(file_.path(), " is gone: its last content stays in force"));
    return tokens_;
  }
  const absl::Status status = Load();
  if (!status.ok() && on_problem_) {
    on_problem_(absl::StrCat(status.message(), "; until then its last content stays in force"));
  }
  return tokens_;
}

bool Tokens::any() { return !Newest()->empty(); }

absl::Status Tokens::CheckTime(const AccessToken& token) const {
  if (token.revoked_ns != 0) {
    return absl::UnauthenticatedError(absl::StrCat("this token was revoked: ", kAskAgain));
  }
  if (token.expires_ns != 0 && clock_.NowNs() >= token.expires_ns) {
    return absl::UnauthenticatedError(absl::StrCat("this token has expired: ", kAskAgain));
  }
  return absl::OkStatus();
}

absl::StatusOr<AccessToken> Tokens::Check(absl::string_view secret) {
  const Snapshot tokens = Newest();
  const std::string hash = HashOf(secret);
  const StoredToken* found = nullptr;
  // All of them are looked at, so that the time says nothing.
  for (const StoredToken& token : *tokens) {
    if (io::SameSecret(token.hash, hash)) found = &token;
  }
  if (found == nullptr) {
    return absl::UnauthenticatedError(absl::StrCat("this token is not valid: ", kAskAgain));
  }
  if (absl::Status status = CheckTime(found->token); !status.ok()) return status;
  return found->token;
}

absl::Status Tokens::StillHolds(const std::string& name) {
  const Snapshot tokens = Newest();
  const StoredToken* found = Named(*tokens, name);
  if (found != nullptr) return CheckTime(found->token);
  return absl::UnauthenticatedError(absl::StrCat("this token is not valid any more: ", kAskAgain));
}

absl::Status Tokens::Change(const std::function<absl::Status(std::vector<StoredToken>&)>& change) {
  if (absl::Status status = file_.Update(change); !status.ok()) return status;
  MutexLock lock(&mutex_);
  return Load();
}

absl::StatusOr<NewAccessToken> Tokens::Create(AccessToken wanted) {
  if (absl::Status status = CheckToken(wanted); !status.ok()) return status;
  const int64_t now_ns = clock_.NowNs();
  wanted.created_ns = now_ns / kNsPerSecond * kNsPerSecond;
  wanted.revoked_ns = 0;
  if (wanted.expires_ns != 0 && wanted.expires_ns <= now_ns) {
    return absl::InvalidArgumentError("the token would have expired already: give a later time");
  }
  if (wanted.expires_ns > std::numeric_limits<int64_t>::max() - kNsPerSecond) {
    return absl::InvalidArgumentError("that time is too late: give an earlier one, or 0 for never");
  }
  wanted.expires_ns = SecondFrom(wanted.expires_ns);
  const absl::StatusOr<std::string> secret = NewSecret();
  if (!secret.ok()) return secret.status();
  const std::string hash = HashOf(*secret);
  if (hash.empty()) return absl::ResourceExhaustedError("no memory to make a token: try again");
  const absl::Status status = Change([&](std::vector<StoredToken>& tokens) -> absl::Status {
    if (Named(tokens, wanted.name) != nullptr) {
      return absl::AlreadyExistsError(
          absl::StrCat("there is, or was, a token \"", wanted.name, "\": give it another name"));
    }
    if (absl::Status room = MakeRoom(tokens); !room.ok()) return room;
    tokens.push_back({wanted, hash});
    return absl::OkStatus();
  });
  if (!status.ok()) return status;
  return NewAccessToken{wanted, *secret};
}

absl::StatusOr<AccessToken> Tokens::Revoke(const std::string& name,
                                           const std::function<bool(const AccessToken&)>& may) {
  AccessToken revoked;
  const absl::Status status = Change([&](std::vector<StoredToken>& tokens) -> absl::Status {
    for (StoredToken& stored : tokens) {
      if (stored.token.name != name || (may && !may(stored.token))) continue;
      if (stored.token.revoked_ns == 0) stored.token.revoked_ns = SecondFrom(clock_.NowNs());
      revoked = stored.token;
      return absl::OkStatus();
    }
    return absl::NotFoundError(
        "there is no token of that name: `isthmus token list` shows all tokens");
  });
  if (!status.ok()) return status;
  return revoked;
}

std::vector<AccessToken> Tokens::List() {
  const Snapshot tokens = Newest();
  std::vector<AccessToken> list;
  list.reserve(tokens->size());
  for (const StoredToken& stored : *tokens) list.push_back(stored.token);
  return list;
}

std::string Tokens::PrintThoseOf(absl::string_view site) {
  std::vector<StoredToken> tokens = *Newest();
  std::erase_if(tokens, [&](const StoredToken& stored) {
    Caller caller;
    caller.sites = stored.token.sites;
    return !caller.MaySee(site);
  });
  return tokens.empty() ? "" : PrintTokens(tokens);
}

}  // namespace isthmus::access
