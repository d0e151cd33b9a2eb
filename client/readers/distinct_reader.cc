#include "client/readers/distinct_reader.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <cstdint>
#include <deque>
#include <utility>

#include "client/readers/limits.h"
#include "core/content_hash.h"

namespace isthmus::readers {
namespace {

class DistinctReader : public ScanReader {
 public:
  explicit DistinctReader(std::unique_ptr<ScanReader> reader) : reader_(std::move(reader)) {}

  absl::StatusOr<std::optional<RecordedScan>> Next() override {
    while (true) {
      absl::StatusOr<std::optional<RecordedScan>> scan = reader_->Next();
      if (!scan.ok() || !scan->has_value() || IsNew(**scan)) return scan;
      ++twins_;
    }
  }
  std::optional<uint64_t> size() const override { return reader_->size(); }
  std::string sensor() const override { return reader_->sensor(); }
  bool has_stamps() const override { return reader_->has_stamps(); }
  std::vector<std::string> Assumptions() const override {
    std::vector<std::string> all = reader_->Assumptions();
    if (twins_ > 0) {
      all.push_back(absl::StrCat(twins_, twins_ == 1 ? " scan is" : " scans are",
                                 " in the recording twice, with the same stamp and points: the "
                                 "second of each is left out"));
    }
    return all;
  }
  void Interrupt() override { reader_->Interrupt(); }

 private:
  bool IsNew(const RecordedScan& scan) {
    ContentHash hash;
    hash.Add(static_cast<uint64_t>(scan.end_stamp_ns));
    hash.AddBytes(scan.payload.data.data(), scan.payload.data.size());
    if (std::find(last_.begin(), last_.end(), hash.value()) != last_.end()) return false;
    if (last_.size() == kDistinctScans) last_.pop_front();
    last_.push_back(hash.value());
    return true;
  }

  const std::unique_ptr<ScanReader> reader_;
  std::deque<uint64_t> last_;  // Hashes of scans.
  uint64_t twins_ = 0;
};

}  // namespace

std::unique_ptr<ScanReader> LeaveOutTwins(std::unique_ptr<ScanReader> reader) {
  return std::make_unique<DistinctReader>(std::move(reader));
}

}  // namespace isthmus::readers
