// A small certificate authority in a folder, for a field trial: it signs the server's certificate
// and, where robots are to show who they are, theirs.
//
// DIR/ca.pem, ca.key; server.pem, server.key; NAME.pem, NAME.key of each client. Keys are of
// P-256 and readable by their owner alone. Whoever has ca.key can sign: it need not be on the
// server, nor on a robot.
#pragma once

#include <absl/status/status.h>
#include <absl/time/time.h>

#include <string>
#include <vector>

namespace isthmus::certificates {

inline constexpr char kServerName[] = "server";

// A new authority. AlreadyExists where the folder has one: its certificates would be worth nothing.
absl::Status MakeAuthority(const std::string& folder, absl::Duration valid_for);

// Signs a new key for the server, in place of an earlier one; `hosts` are the names and addresses
// under which clients reach it. Both files are replaced as a whole. InvalidArgument without hosts,
// NotFound where the folder has no authority.
absl::Status IssueServer(const std::string& folder, const std::vector<std::string>& hosts,
                         absl::Duration valid_for);

// Signs a new key for a client in the same way. InvalidArgument for a name that is not of
// [A-Za-z0-9_.-], or that another file of the folder has.
absl::Status IssueClient(const std::string& folder, const std::string& name,
                         absl::Duration valid_for);

}  // namespace isthmus::certificates
