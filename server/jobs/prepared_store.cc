#include "server/jobs/prepared_store.h"

#include <string>
#include <utility>

#include "core/codec/zstd_frame.h"
#include "server/jobs/limits.h"
#include "server/matching/prepared/prepared_submap_codec.h"

namespace isthmus::server {

absl::StatusOr<std::shared_ptr<const matching::PreparedSubmap>> PreparedStore::Get(
    const std::shared_ptr<const Submap>& outline, const std::stop_token& stop) const {
  if (auto found = Find(outline)) return found;
  const absl::StatusOr<std::shared_ptr<const Submap>> whole = submaps_->TryGet(outline->id);
  if (absl::IsNotFound(whole.status()) || absl::IsDataLoss(whole.status())) {
    return std::make_shared<const matching::PreparedSubmap>(outline);
  }
  if (!whole.ok()) return whole.status();
  auto made = std::make_shared<const matching::PreparedSubmap>(outline, **whole, stop);
  if (stop.stop_requested()) return absl::CancelledError("stopped");
  const std::string bytes = matching::EncodePreparedSubmap(*made);
  StorePrepared(outline->id, bytes);
  // As all others will read it, rounded: what is matched with it is the same to the last bit
  // whoever made it.
  auto read = matching::DecodePreparedSubmap(outline, bytes);
  return read ? read : made;
}

std::shared_ptr<const matching::PreparedSubmap> PreparedStore::Find(
    const std::shared_ptr<const Submap>& outline) const {
  const absl::StatusOr<std::string> kept =
      store_->GetFeatures(outline->id, matching::kPreparedSubmapKind);
  if (!kept.ok()) return nullptr;
  const absl::StatusOr<std::string> bytes = codec::UnpackZstd(*kept, kMaxPreparedBytes);
  if (!bytes.ok()) return nullptr;
  return matching::DecodePreparedSubmap(outline, *bytes);
}

void PreparedStore::StorePrepared(const SubmapId& submap, const std::string& bytes) const {
  auto data = codec::PackZstd(bytes);
  if (!data.ok()) return;
  (void)store_->PutFeatures({submap, matching::kPreparedSubmapKind, *std::move(data)});
}

}  // namespace isthmus::server
