#include "client/readers/started_reader.h"

#include "client/readers/limits.h"
#include "client/readers/ring_sensor.h"

namespace isthmus::readers {

StartedReader::StartedReader(std::unique_ptr<ScanReader> reader) : reader_(std::move(reader)) {
  while (ahead_.size() < kErrorsReadAhead) {
    ahead_.push_back(reader_->Next());
    if (!ahead_.back().ok()) continue;
    if (ahead_.back()->has_value()) first_ = &**ahead_.back();
    break;
  }
  sensor_ = reader_->sensor();
  if (!sensor_.empty() || first_ == nullptr) return;
  RingSensor rings;
  rings.Look(first_->payload);
  sensor_ = rings.sensor();
}

absl::StatusOr<std::optional<RecordedScan>> StartedReader::Next() {
  if (ahead_.empty()) return reader_->Next();
  absl::StatusOr<std::optional<RecordedScan>> next = std::move(ahead_.front());
  ahead_.pop_front();
  if (next.ok()) first_ = nullptr;
  return next;
}

}  // namespace isthmus::readers
