#include "server/access/token_text.h"

#include <absl/strings/escaping.h>
#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <absl/strings/str_join.h>
#include <absl/strings/str_split.h>
#include <absl/time/time.h>

#include <algorithm>
#include <set>
#include <utility>

#include "core/io/crc32c.h"
#include "core/plain_text.h"
#include "server/access/limits.h"

namespace isthmus::access {
namespace {

constexpr char kMagic[] = "isthmus-tokens ";
constexpr char kHeader[] =
    "isthmus-tokens 1\n"
    "# `isthmus token` changes this file. It has no secrets, but the SHA-256 of each.\n";
constexpr char kSum[] = "crc32c ";
constexpr char kNone[] = "()";  // No list has it: names have no brackets.
constexpr char kUtc[] = "%Y-%m-%dT%H:%M:%SZ";
constexpr std::pair<AccessRole, const char*> kRoles[] = {{AccessRole::kRobot, "robot"},
                                                         {AccessRole::kReader, "reader"},
                                                         {AccessRole::kOperator, "operator"},
                                                         {AccessRole::kAdmin, "admin"}};

bool IsName(absl::string_view text, bool stars) {
  const auto fits = [stars](char c) {
    return absl::ascii_isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '.' || c == '-' ||
           (stars && c == '*');
  };
  return !text.empty() && text.size() <= kMaxName && std::all_of(text.begin(), text.end(), fits);
}

absl::Status CheckPatterns(const std::vector<std::string>& patterns, const char* what) {
  if (patterns.size() > kMaxPatterns) {
    return absl::InvalidArgumentError(absl::StrCat("a token takes ", kMaxPatterns, " names of ",
                                                   what, " at most: use a pattern with *"));
  }
  for (const std::string& pattern : patterns) {
    if (IsName(pattern, true)) continue;
    return absl::InvalidArgumentError(
        absl::StrCat("\"", absl::CHexEscape(pattern.substr(0, kMaxName)), "\" is not a name of ",
                     what, ": use up to ", kMaxName, " of [A-Za-z0-9_.-], and * for any"));
  }
  return absl::OkStatus();
}

std::string StampText(int64_t ns) {
  return ns == 0 ? "-" : absl::FormatTime(kUtc, absl::FromUnixNanos(ns), absl::UTCTimeZone());
}

bool ParseStamp(const std::string& text, int64_t* ns) {
  *ns = 0;
  if (text == "-") return true;
  absl::Time time;
  if (!absl::ParseTime(kUtc, text, absl::UTCTimeZone(), &time, nullptr)) return false;
  *ns = absl::ToUnixNanos(time);
  return true;
}

std::string ListText(const std::vector<std::string>& patterns) {
  return patterns.empty() ? kNone : absl::StrJoin(patterns, ",");
}

std::vector<std::string> ParseList(const std::string& text) {
  if (text == kNone) return {};
  return absl::StrSplit(text, ',');
}

// The value of "key=value"; nothing where that is not the key.
std::string ValueOf(const std::string& word, const std::string& key) {
  return word.rfind(key + "=", 0) == 0 ? word.substr(key.size() + 1) : "";
}

std::string Line(const StoredToken& stored) {
  const AccessToken& token = stored.token;
  return absl::StrCat(
      "token ", token.name, " role=", RoleName(token.role), " robots=", ListText(token.robots),
      " sites=", ListText(token.sites), " created=", StampText(token.created_ns),
      " expires=", StampText(token.expires_ns), " revoked=", StampText(token.revoked_ns),
      " sha256=", absl::BytesToHexString(stored.hash), "\n");
}

bool ParseLine(const std::string& line, StoredToken* stored) {
  const std::vector<std::string> words = absl::StrSplit(line, ' ');
  if (words.size() != 9 || words[0] != "token") return false;
  AccessToken& token = stored->token;
  token.name = words[1];
  const auto role = ParseRole(ValueOf(words[2], "role"));
  if (!role.ok()) return false;
  token.role = *role;
  token.robots = ParseList(ValueOf(words[3], "robots"));
  token.sites = ParseList(ValueOf(words[4], "sites"));
  const std::string hash = ValueOf(words[8], "sha256");
  if (hash.size() != 64 || !std::all_of(hash.begin(), hash.end(), absl::ascii_isxdigit)) {
    return false;
  }
  stored->hash = absl::HexStringToBytes(hash);
  return ParseStamp(ValueOf(words[5], "created"), &token.created_ns) &&
         ParseStamp(ValueOf(words[6], "expires"), &token.expires_ns) &&
         ParseStamp(ValueOf(words[7], "revoked"), &token.revoked_ns) && CheckToken(token).ok();
}

}  // namespace

std::string RoleName(AccessRole role) {
  for (const auto& [known, name] : kRoles) {
    if (known == role) return name;
  }
  return "?";
}

absl::StatusOr<AccessRole> ParseRole(const std::string& name) {
  for (const auto& [role, known] : kRoles) {
    if (known == name) return role;
  }
  return absl::InvalidArgumentError("a role is one of robot, reader, operator, admin");
}

absl::Status CheckToken(const AccessToken& token) {
  if (WithoutSecrets(token.name) != token.name) {
    return absl::InvalidArgumentError(
        "this is a token's secret, but a name is shown to others: give another name");
  }
  if (!IsName(token.name, false)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "a token's name has 1 to ", kMaxName, " characters of [A-Za-z0-9_.-]: give it another"));
  }
  if (token.role == AccessRole::kRobot && token.robots.empty()) {
    return absl::InvalidArgumentError(
        "a robot's token must name the robots whose scans it may send");
  }
  if (token.role == AccessRole::kAdmin && !token.robots.empty()) {
    return absl::InvalidArgumentError("an administrator may send scans of all robots: name none");
  }
  if (token.sites.empty()) return absl::InvalidArgumentError("a token must name a site, or *");
  if (absl::Status robots = CheckPatterns(token.robots, "a robot"); !robots.ok()) return robots;
  return CheckPatterns(token.sites, "a site");
}

std::string SumLine(const std::string& text) {
  return absl::StrFormat("%s%08x\n", kSum, io::Crc32c(text.data(), text.size()));
}

std::string PrintTokens(const std::vector<StoredToken>& tokens) {
  std::string text = kHeader;
  for (const StoredToken& token : tokens) text += Line(token);
  return text + SumLine(text);
}

absl::StatusOr<std::vector<StoredToken>> ParseTokens(const std::string& text) {
  int version = 0;
  if (text.rfind(kMagic, 0) == 0 &&
      absl::SimpleAtoi(text.substr(sizeof(kMagic) - 1, text.find('\n') - sizeof(kMagic) + 1),
                       &version) &&
      version > 1) {
    return absl::FailedPreconditionError("a newer version of Isthmus wrote it");
  }
  const size_t sum = text.rfind(kSum);
  if (text.rfind(kHeader, 0) != 0 || sum == std::string::npos ||
      text.substr(sum) != SumLine(text.substr(0, sum))) {
    return absl::DataLossError("its checksum does not fit its content");
  }
  std::vector<StoredToken> tokens;
  std::set<std::string> names;
  const std::string lines = text.substr(sizeof(kHeader) - 1, sum - (sizeof(kHeader) - 1));
  for (const std::string& line : std::vector<std::string>(absl::StrSplit(lines, '\n'))) {
    if (line.empty()) continue;
    StoredToken token;
    if (!ParseLine(line, &token) || !names.insert(token.token.name).second) {
      return absl::DataLossError(absl::StrCat("token ", tokens.size() + 1, " makes no sense"));
    }
    tokens.push_back(std::move(token));
  }
  return tokens;
}

}  // namespace isthmus::access
