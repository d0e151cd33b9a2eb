#include "client/readers/packets/scan_builder.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <array>
#include <utility>

#include "core/codec/column.h"

namespace isthmus::readers {
namespace {

constexpr uint32_t kRingOffset = 16;  // Layout
constexpr uint32_t kTimeOffset = 18;  // Layout
constexpr uint32_t kMoreOffset = 22;  // Layout

}  // namespace

ScanBuilder::ScanBuilder(const std::vector<PointField>& more)
    : fields_{{"x", 0},
              {"y", 4},
              {"z", 8},
              {"intensity", 12},
              {"ring", kRingOffset, ScalarType::kUint16},
              {"time", kTimeOffset, ScalarType::kFloat32}},
      stride_(kMoreOffset) {
  for (PointField field : more) {
    field.offset = stride_;
    stride_ += SizeOf(field.type) * field.count;
    fields_.push_back(std::move(field));
  }
}

char* ScanBuilder::Add(const Record& point, int64_t time_ns) {
  const size_t at = data_.size();
  data_.resize(at + stride_);
  char* record = data_.data() + at;
  codec::StoreAs(std::array<float, 4>{point.x, point.y, point.z, point.intensity}, record);
  codec::StoreAs(point.ring, record + kRingOffset);
  times_.push_back(time_ns);
  return record + kMoreOffset;
}

RecordedScan ScanBuilder::Finish(int64_t offset_ns) {
  const int64_t end_ns = *std::max_element(times_.begin(), times_.end());
  char* record = data_.data() + kTimeOffset;
  for (const int64_t time_ns : times_) {
    codec::StoreAs(static_cast<float>(static_cast<double>(time_ns - end_ns) * 1e-9), record);
    record += stride_;
  }
  RecordedScan scan;
  scan.end_stamp_ns = end_ns + offset_ns;
  scan.name = absl::StrCat("scan ", scans_++);
  scan.payload.width = static_cast<uint32_t>(times_.size());
  scan.payload.stride = stride_;
  scan.payload.fields = fields_;
  const size_t bytes = data_.size(), points = times_.size();
  scan.payload.data = std::move(data_);
  data_ = {};
  times_.clear();
  data_.reserve(bytes + bytes / 16);  // The next scan is about as large.
  times_.reserve(points);
  return scan;
}

}  // namespace isthmus::readers
