// The tokens of a server: made, revoked, and asked for by every call.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/clock.h"
#include "core/concurrency/mutex.h"
#include "core/records/access_token.h"
#include "server/access/token_file.h"

namespace isthmus::access {

// The sites of a new token for which none were named: the default site, or for an administrator the
// sites of its maker.
std::vector<std::string> SitesUnlessNamed(AccessRole role, std::vector<std::string> of_maker);

// Changes of the file by other processes show within a second (kLookAgainNs). A file that is
// damaged or vanishes while it is open changes nothing: the tokens read last hold. Thread safe.
class Tokens {
 public:
  // Told, in a sentence, when the file cannot be read any more; may be null.
  using OnProblem = std::function<void(const std::string&)>;

  // Errors of TokenFile::Read. The clock must outlive it.
  static absl::StatusOr<std::unique_ptr<Tokens>> Open(const std::string& folder,
                                                      OnProblem on_problem = nullptr,
                                                      const Clock& clock = Clock::System());

  // True if there is any token, be it revoked or expired.
  bool any();
  // The token of that secret. Unauthenticated where it is none, was revoked, or has expired.
  absl::StatusOr<AccessToken> Check(absl::string_view secret);
  // The same of a token that was let in before: Unauthenticated once it was revoked or has expired.
  absl::Status StillHolds(const std::string& name);

  // Makes one of these properties; `created_ns` and `revoked_ns` are not looked at. InvalidArgument
  // as CheckToken, or for an expiry that is past; AlreadyExists for a name that is or was in use;
  // ResourceExhausted when there are kMaxTokens.
  absl::StatusOr<NewAccessToken> Create(AccessToken wanted);
  // Revoking twice is no error. NotFound where there is no such token, or `may` is given and false
  // of it.
  absl::StatusOr<AccessToken> Revoke(const std::string& name,
                                     const std::function<bool(const AccessToken&)>& may = nullptr);
  std::vector<AccessToken> List();  // In order of creation.
  // The tokens for that site, as the file of another folder; empty if there are none.
  std::string PrintThoseOf(absl::string_view site);

 private:
  using Snapshot = std::shared_ptr<const std::vector<StoredToken>>;

  Tokens(const std::string& folder, OnProblem on_problem, const Clock& clock)
      : file_(folder), on_problem_(std::move(on_problem)), clock_(clock) {}
  // As of the last look at the file, which is at most so old.
  Snapshot Newest();
  absl::Status Load() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  absl::Status CheckTime(const AccessToken& token) const;
  // Changes the file, and looks at it again.
  absl::Status Change(const std::function<absl::Status(std::vector<StoredToken>&)>& change);

  const TokenFile file_;
  const OnProblem on_problem_;
  const Clock& clock_;
  Mutex mutex_;
  Snapshot tokens_ ABSL_GUARDED_BY(mutex_);
  TokenFile::Version version_ ABSL_GUARDED_BY(mutex_);
  int64_t looked_ns_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace isthmus::access
