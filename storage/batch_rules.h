// What a batch must satisfy before any store takes it, and the words both stores refuse with.
#pragma once

#include <absl/status/status.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>

#include "core/ids.h"
#include "storage/map_store.h"

namespace isthmus::storage {

// Limits of a submap; what is encoded stays within those of core/codec/quantized.h.
inline constexpr size_t kMaxSubmapPoints = 4'000'000;
inline constexpr float kMaxCoordinateM = 5000;

// What a store holds already.
struct StoreContents {
  std::function<bool(const SessionId&)> has_session;
  std::function<bool(const SubmapId&)> has_submap;
  int64_t latest_revision = 0;
};

// Sessions that the batch itself inserts count as held. InvalidArgument for empty ids, a match
// whose pair is not ordered, poses or information that are not finite, a submap without keyframes,
// with points of keyframes it does not have or beyond the limits above; else the errors of
// MapStore::Write.
absl::Status CheckBatch(const WriteBatch& batch, const StoreContents& contents);

absl::Status UnknownSession(const SessionId& session);
absl::Status UnknownSubmap(const SubmapId& submap);
absl::Status NoFeatures(const SubmapId& submap, const std::string& kind);

}  // namespace isthmus::storage
