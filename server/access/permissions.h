// The table of who may call what.
#pragma once

#include <absl/status/status.h>
#include <absl/strings/string_view.h>

#include <vector>

#include "server/access/caller.h"

namespace isthmus::access {

// PermissionDenied where a caller of that role may not call the method of that bare name
// ("StreamScans"); a method that is not in the table is nobody's.
absl::Status CheckRole(const Caller& caller, absl::string_view rpc);

// The bare names of the methods in the table.
std::vector<absl::string_view> Methods();
// Whether the table has the method.
bool HasRule(absl::string_view rpc);
// Whether it changes the site, or the tokens: no affair of a server that only reads.
bool IsChange(absl::string_view rpc);
bool IsForRobots(absl::string_view rpc);

}  // namespace isthmus::access
