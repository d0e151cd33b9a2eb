#include "client/readers/range_reader.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace isthmus::readers {
namespace {

class RangeReader : public ScanReader {
 public:
  RangeReader(std::unique_ptr<ScanReader> reader, uint64_t from, uint64_t to)
      : reader_(std::move(reader)), from_(from), to_(to) {}

  absl::StatusOr<std::optional<RecordedScan>> Next() override {
    for (; next_ <= to_; ++next_) {
      absl::StatusOr<std::optional<RecordedScan>> scan = reader_->Next();
      const bool is_end = scan.ok() && !scan->has_value();
      if (next_ < from_ && !is_end) continue;
      ++next_;
      return scan;
    }
    return std::nullopt;
  }
  std::optional<uint64_t> size() const override {
    const std::optional<uint64_t> whole = reader_->size();
    if (!whole) return std::nullopt;
    return from_ >= *whole ? 0 : std::min(to_, *whole - 1) - from_ + 1;
  }
  std::string sensor() const override { return reader_->sensor(); }
  bool has_stamps() const override { return reader_->has_stamps(); }
  std::vector<std::string> Assumptions() const override { return reader_->Assumptions(); }
  void Interrupt() override { reader_->Interrupt(); }

 private:
  const std::unique_ptr<ScanReader> reader_;
  const uint64_t from_, to_;
  uint64_t next_ = 0;
};

}  // namespace

std::unique_ptr<ScanReader> TakeRange(std::unique_ptr<ScanReader> reader, uint64_t from,
                                      std::optional<uint64_t> to) {
  if (from == 0 && !to) return reader;
  return std::make_unique<RangeReader>(std::move(reader), from,
                                       to.value_or(std::numeric_limits<uint64_t>::max() - 1));
}

}  // namespace isthmus::readers
