// The table of the methods: the callers of each, the number of calls at a time, and the methods
// that change the site.
#pragma once

#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>
#include <absl/types/span.h>

#include "server/access/caller.h"

namespace isthmus::access {

// The limit that a call counts to; see rpc::CallLimits. Any number runs of the others.
enum class CallKind { kStream, kQuery, kExport, kList, kOther };

// The bit of a role in Method::roles.
constexpr unsigned Bit(Role role) { return 1u << static_cast<unsigned>(role); }

struct Method {
  absl::string_view name;  // Bare: "StreamScans".
  unsigned roles = 0;      // A bit for each Role that may call it.
  CallKind kind = CallKind::kOther;
  bool changes = false;  // The site, or the tokens: no affair of a server that only reads.

  bool IsForRobots() const { return (roles & Bit(Role::kRobot)) != 0; }
};

absl::Span<const Method> Methods();
// Null for a method that is not in the table: it is nobody's.
const Method* FindMethod(absl::string_view name);

// The method of that name, never null; PermissionDenied where the caller's roles may not call it.
absl::StatusOr<const Method*> AllowedMethod(const Caller& caller, absl::string_view name);

}  // namespace isthmus::access
