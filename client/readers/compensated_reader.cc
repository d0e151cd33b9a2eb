#include "client/readers/compensated_reader.h"

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
    } else if (!first_is_) {
      first_is_ = codec::HasEmptyTimes(payload);
    }
    return scan;
  }
  std::optional<uint64_t> size() const override { return reader_->size(); }
  std::string sensor() const override { return reader_->sensor(); }
  bool has_stamps() const override { return reader_->has_stamps(); }
  std::vector<std::string> Assumptions() const override {
    std::vector<std::string> all = reader_->Assumptions();
    if (compensated_.value_or(first_is_.value_or(false))) {
      all.emplace_back(
          "scans are taken to be motion-compensated already, each to the instant of its stamp");
    }
    return all;
  }
  void Interrupt() override { reader_->Interrupt(); }

 private:
  const std::unique_ptr<ScanReader> reader_;
  const std::optional<bool> compensated_;
  std::optional<bool> first_is_;  // The first scan, where nothing is known.
};

}  // namespace

std::unique_ptr<ScanReader> WatchCompensation(std::unique_ptr<ScanReader> reader,
                                              std::optional<bool> compensated) {
  return std::make_unique<CompensatedReader>(std::move(reader), compensated);
}

}  // namespace isthmus::readers
