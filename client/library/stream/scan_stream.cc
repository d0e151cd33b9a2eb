#include "client/library/stream/scan_stream.h"

#include <utility>

#include "client/library/stream/scan_stream_impl.h"
#include "core/codec/payload_builder.h"

namespace isthmus::client {

ScanStream::ScanStream(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
ScanStream::~ScanStream() = default;

absl::Status ScanStream::Push(int64_t end_stamp_ns, PointPayload payload) {
  return impl_->Push(end_stamp_ns, std::move(payload));
}

absl::Status ScanStream::Push(const Scan& scan) {
  return impl_->Push(scan.end_stamp_ns, codec::MakePayload(scan));
}

absl::Status ScanStream::Finish() { return impl_->Finish(); }

absl::StatusOr<SessionStatus> ScanStream::FinishSession() { return impl_->FinishSession(); }

void ScanStream::GiveUp() { impl_->GiveUp(); }

std::optional<bool> ScanStream::IsNewest(int64_t end_stamp_ns, PointPayload payload) const {
  return impl_->IsNewest(end_stamp_ns, std::move(payload));
}

SpoolState ScanStream::resumed() const { return impl_->resumed(); }

SessionId ScanStream::session() const { return impl_->session(); }

ScanStreamStats ScanStream::stats() const { return impl_->stats(); }

}  // namespace isthmus::client
