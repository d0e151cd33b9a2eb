#include "server/access/permissions.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>

#include <string>
#include <vector>

#include "server/access/token_text.h"

namespace isthmus::access {
namespace {

constexpr unsigned Bit(Role role) { return 1u << static_cast<unsigned>(role); }
constexpr unsigned kAdmins = Bit(Role::kAdmin);                  // Layout.
constexpr unsigned kOperators = kAdmins | Bit(Role::kOperator);  // Layout.
constexpr unsigned kReaders = kOperators | Bit(Role::kReader);   // Layout.
constexpr unsigned kRobots = kAdmins | Bit(Role::kRobot);        // Layout.

// Handlers see to it that sessions of its own robots alone are fed by a caller, and known to a
// robot.
struct Rule {
  absl::string_view rpc;
  unsigned roles;
  bool changes = false;  // The site, or who may see it.
};
constexpr Rule kRules[] = {
    {"CreateSession", kRobots, true},
    {"GetSession", kRobots | kReaders},
    {"ListSessions", kRobots | kReaders},
    {"FinishSession", kRobots | kOperators, true},
    {"StreamScans", kRobots, true},
    {"UploadSubmap", kRobots, true},
    {"GetUpload", kRobots, true},
    {"Localise", kRobots},
    {"GetMapInfo", kReaders},
    {"ListSubmaps", kReaders},
    {"GetTrajectory", kReaders},
    {"GetMatchGraph", kReaders},
    {"ListLoops", kReaders},
    {"ListAnchors", kReaders},
    {"ListRevisions", kReaders},
    {"DiffRevisions", kReaders},
    {"GetTransform", kReaders},
    {"QueryRegion", kReaders},
    {"ExportMap", kReaders},
    {"ExportPoseGraph", kReaders},
    {"FindChanges", kReaders},
    {"ListTiles", kReaders},
    {"GetTile", kReaders},
    {"WatchMap", kReaders},
    {"DecideMatch", kOperators, true},
    {"DecideLoop", kOperators, true},
    {"PutAnchor", kOperators, true},
    {"DeleteAnchor", kOperators, true},
    {"SetDatum", kOperators, true},
    {"UndoRevision", kOperators, true},
    {"DeleteSession", kOperators, true},
    {"ListEvents", kOperators},
    {"WatchEvents", kOperators},
    {"BackUp", kAdmins},
    {"GetStatus", kReaders},
    {"CreateToken", kAdmins, true},
    {"ListTokens", kAdmins},
    {"RevokeToken", kAdmins, true},
    {"GetOwnToken", kRobots | kReaders},
    {"ServerReflectionInfo", kAdmins},
};

const Rule* FindRule(absl::string_view rpc) {
  for (const Rule& rule : kRules) {
    if (rule.rpc == rpc) return &rule;
  }
  return nullptr;
}

// A caller that is given robots may feed them, beside the rest of its rights.
unsigned RolesOf(const Caller& caller) {
  return Bit(caller.role) | (caller.robots.empty() ? 0 : Bit(Role::kRobot));
}

unsigned RolesFor(absl::string_view rpc) {
  const Rule* rule = FindRule(rpc);
  return rule == nullptr ? 0 : rule->roles;
}

}  // namespace

std::vector<absl::string_view> Methods() {
  std::vector<absl::string_view> methods;
  for (const Rule& rule : kRules) methods.push_back(rule.rpc);
  return methods;
}

bool HasRule(absl::string_view rpc) { return RolesFor(rpc) != 0; }

bool IsChange(absl::string_view rpc) {
  const Rule* rule = FindRule(rpc);
  return rule != nullptr && rule->changes;
}

bool IsForRobots(absl::string_view rpc) { return (RolesFor(rpc) & Bit(Role::kRobot)) != 0; }

absl::Status CheckRole(const Caller& caller, absl::string_view rpc) {
  const unsigned roles = RolesFor(rpc);
  if ((roles & RolesOf(caller)) != 0) return absl::OkStatus();
  std::vector<std::string> names;
  for (const Role role : {Role::kRobot, Role::kReader, Role::kOperator, Role::kAdmin}) {
    if ((roles & Bit(role)) != 0) names.push_back(RoleName(role));
  }
  if (names.empty()) names.emplace_back("nobody");
  return absl::PermissionDeniedError(
      absl::StrCat(rpc, " is for ", absl::StrJoin(names, ", "), "; this token's role is ",
                   RoleName(caller.role), ": ask an administrator for a token of another role"));
}

}  // namespace isthmus::access
