#include "server/access/methods.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>

#include <algorithm>
#include <string>
#include <vector>

#include "server/access/token_text.h"

namespace isthmus::access {
namespace {

constexpr unsigned kAdmins = Bit(Role::kAdmin);                  // Layout.
constexpr unsigned kOperators = kAdmins | Bit(Role::kOperator);  // Layout.
constexpr unsigned kReaders = kOperators | Bit(Role::kReader);   // Layout.
constexpr unsigned kRobots = kAdmins | Bit(Role::kRobot);        // Layout.

// Handlers see to it that sessions of its own robots alone are fed by a caller, and known to a
// robot.
constexpr Method kMethods[] = {
    {"CreateSession", kRobots, CallKind::kOther, true},
    {"GetSession", kRobots | kReaders},
    {"ListSessions", kRobots | kReaders, CallKind::kList},
    {"FinishSession", kRobots | kOperators, CallKind::kOther, true},
    {"StreamScans", kRobots, CallKind::kStream, true},
    {"UploadSubmap", kRobots, CallKind::kStream, true},
    {"GetUpload", kRobots, CallKind::kOther, true},
    {"Localise", kRobots, CallKind::kStream},
    {"GetMapInfo", kReaders},
    {"ListSubmaps", kReaders, CallKind::kList},
    {"GetTrajectory", kReaders, CallKind::kList},
    {"GetMatchGraph", kReaders, CallKind::kList},
    {"ListLoops", kReaders, CallKind::kList},
    {"ListAnchors", kReaders, CallKind::kList},
    {"ListRevisions", kReaders, CallKind::kList},
    {"DiffRevisions", kReaders, CallKind::kList},
    {"GetTransform", kReaders},
    {"QueryRegion", kReaders, CallKind::kQuery},
    {"ExportMap", kReaders, CallKind::kExport},
    {"ExportPoseGraph", kReaders, CallKind::kExport},
    {"FindChanges", kReaders, CallKind::kExport},
    {"ListTiles", kReaders, CallKind::kList},
    {"GetTile", kReaders},
    {"WatchMap", kReaders, CallKind::kStream},
    {"DecideMatch", kOperators, CallKind::kOther, true},
    {"DecideLoop", kOperators, CallKind::kOther, true},
    {"PutAnchor", kOperators, CallKind::kOther, true},
    {"DeleteAnchor", kOperators, CallKind::kOther, true},
    {"SetDatum", kOperators, CallKind::kOther, true},
    {"UndoRevision", kOperators, CallKind::kOther, true},
    {"DeleteSession", kOperators, CallKind::kOther, true},
    {"ListEvents", kOperators, CallKind::kList},
    {"WatchEvents", kOperators, CallKind::kStream},
    {"BackUp", kAdmins},
    {"GetStatus", kReaders},
    {"CreateToken", kAdmins, CallKind::kOther, true},
    {"ListTokens", kAdmins, CallKind::kList},
    {"RevokeToken", kAdmins, CallKind::kOther, true},
    {"GetOwnToken", kRobots | kReaders},
    {"ServerReflectionInfo", kAdmins},
};

// A caller that is given robots may feed them, beside the rest of its rights.
unsigned RolesOf(const Caller& caller) {
  return Bit(caller.role) | (caller.robots.empty() ? 0 : Bit(Role::kRobot));
}

}  // namespace

absl::Span<const Method> Methods() { return kMethods; }

const Method* FindMethod(absl::string_view name) {
  const auto found = std::find_if(std::begin(kMethods), std::end(kMethods),
                                  [name](const Method& method) { return method.name == name; });
  return found == std::end(kMethods) ? nullptr : &*found;
}

absl::StatusOr<const Method*> AllowedMethod(const Caller& caller, absl::string_view name) {
  const Method* method = FindMethod(name);
  const unsigned roles = method == nullptr ? 0 : method->roles;
  if ((roles & RolesOf(caller)) != 0) return method;
  std::vector<std::string> names;
  for (const Role role : {Role::kRobot, Role::kReader, Role::kOperator, Role::kAdmin}) {
    if ((roles & Bit(role)) != 0) names.push_back(RoleName(role));
  }
  if (names.empty()) names.emplace_back("nobody");
  return absl::PermissionDeniedError(
      absl::StrCat(name, " is for ", absl::StrJoin(names, ", "), "; this token's role is ",
                   RoleName(caller.role), ": ask an administrator for a token of another role"));
}

}  // namespace isthmus::access
