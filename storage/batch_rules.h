// Rules that a batch must satisfy before any store takes it, and the words with which both stores
// refuse.
#pragma once

#include <absl/status/status.h>

#include <cstdint>
#include <functional>
#include <string>

#include "core/ids.h"
#include "storage/map_store.h"

namespace isthmus::storage {

// The contents of a store, as the rules need them.
struct StoreContents {
  std::function<bool(const SessionId&)> has_session;
  std::function<bool(const SubmapId&)> has_submap;
  int64_t latest_revision = 0;
};

// Sessions and submaps that the batch itself inserts count as held, a session from its place in the
// batch on where a segment names it. InvalidArgument for empty ids, segments numbered wrongly,
// pairs that are not ordered, moves without a revision, and records that record_rules.h refuses;
// else the errors of MapStore::Write.
absl::Status CheckBatch(const WriteBatch& batch, const StoreContents& contents);

absl::Status UnknownSession(const SessionId& session);
absl::Status UnknownSubmap(const SubmapId& submap);
absl::Status NoCheckpoint(const SessionId& session);
absl::Status NoFeatures(const SubmapId& submap, const std::string& kind);

}  // namespace isthmus::storage
