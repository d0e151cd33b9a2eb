// The identity of a spool: whose scans it holds. Private to the library.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <cstdint>
#include <string>

#include "isthmus/v1/session_service.pb.h"

namespace isthmus::client {

struct SpoolIdentity {
  // The request that made, or will make, the session; its request_id is the spool's own name, and
  // behind a '.' that of a session to which it changed over.
  v1::CreateSessionRequest request;
  std::string session;  // Its id; empty until the server has told.
  // When it was opened, by which it is told from another of its name; 0: not known, as of spools of
  // older programs.
  int64_t created_ns = 0;
  // A scan's sequence at the server is that in the spool less this: not 0 where the spool changed
  // over to another session.
  uint64_t base = 0;
  bool closed = false;  // No more scans come: a newer session of the robot took over.
  // Not 0: scans from this one on were taken while it was not known whether the server had others
  // of their numbers, as where a damaged spool was opened out of its reach.
  uint64_t unsure_from = 0;

  // The spool's own name, which its files carry.
  std::string name() const {
    return request.request_id().substr(0, request.request_id().find('.'));
  }
};

// The files of scans in a folder are called so, behind a number.
constexpr char kScansSuffix[] = ".scans";

// Into `folder`/session; it is there as before or as now whatever happens. Errors are
// io::FileError's.
absl::Status WriteIdentity(const std::string& folder, const SpoolIdentity& identity);
// Reads `folder`/session; DataLoss when it is missing or damaged.
absl::StatusOr<SpoolIdentity> ReadIdentity(const std::string& folder);
// The scans in `folder` are needed no more: what a death of the program leaves of it is of no use.
absl::Status RetireIdentity(const std::string& folder);
// True where a program died while it made or removed `folder`: no scan is in it that is needed.
bool IsOfNoUse(const std::string& folder);

// DataLoss that says `why` it is not known whose scans `folder` holds, and what to do.
absl::Status UnknownOwner(const std::string& folder, const std::string& why);

// 128 random bits as text.
std::string NewRequestId();

}  // namespace isthmus::client
