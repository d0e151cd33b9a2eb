#include "client/readers/compensated_reader.h"

#include <absl/strings/str_cat.h>

#include <cstdint>
#include <utility>

#include "core/codec/time_field.h"

namespace isthmus::readers {
namespace {

class CompensatedReader : public ScanReader {
 public:
  CompensatedReader(std::unique_ptr<ScanReader> reader, std::optional<bool> compensated)
      : reader_(std::move(reader)), compensated_(compensated) {}

  absl::StatusOr<std::optional<RecordedScan>> Next() override {
    absl::StatusOr<std::optional<RecordedScan>> scan = reader_->Next();
    if (!scan.ok() || !scan->has_value()) return scan;
    PointPayload& payload = (*scan)->payload;
    if (compensated_ == true) {
      codec::ClearTimes(payload);
    } else if (compensated_ == false) {
      if (codec::HasEmptyTimes(payload)) codec::DropTimes(payload);
    } else {
      Watch(payload);
    }
    return scan;
  }
  std::optional<uint64_t> size() const override { return reader_->size(); }
  std::string sensor() const override { return reader_->sensor(); }
  bool has_stamps() const override { return reader_->has_stamps(); }
  std::vector<std::string> Assumptions() const override {
    std::vector<std::string> all = reader_->Assumptions();
    if (compensated_.value_or(empty_ > 0 && !has_times_)) {
      all.emplace_back(
          "scans are taken to be motion-compensated already, each to the instant of its stamp");
    } else if (empty_ > 0) {
      all.push_back(absl::StrCat("points of the first ", empty_,
                                 " scans have times of 0 alone, and later ones true times: the "
                                 "scans are not taken to be motion-compensated"));
    }
    return all;
  }
  void Interrupt() override { reader_->Interrupt(); }

 private:
  // Drivers leave times empty in the scans with which they start.
  void Watch(const PointPayload& payload) {
    if (has_times_) return;
    if (codec::HasEmptyTimes(payload)) {
      ++empty_;
    } else {
      has_times_ = codec::ReadTimeField(payload).has_value();
    }
  }

  const std::unique_ptr<ScanReader> reader_;
  const std::optional<bool> compensated_;
  // Scans of which nothing is known: those with empty times before the first with true ones.
  uint64_t empty_ = 0;
  bool has_times_ = false;
};

}  // namespace

std::unique_ptr<ScanReader> WatchCompensation(std::unique_ptr<ScanReader> reader,
                                              std::optional<bool> compensated) {
  return std::make_unique<CompensatedReader>(std::move(reader), compensated);
}

}  // namespace isthmus::readers
