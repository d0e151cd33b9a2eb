#include "core/formats/kitti_bin.h"

#include <absl/strings/str_cat.h>

#include <cmath>
#include <limits>
#include <utility>

#include "core/codec/column.h"
#include "core/io/file_io.h"

namespace isthmus::formats {
namespace {

// Share of intensities that may be negative. None of a million of KITTI's drive 0005 is. These scans,
// written with 3, 5 or 6 columns or column by column and read as four, gave 16 % and more, as
// coordinates stood in their place.
constexpr double kMostNegative = 0.01;
// Rings that a column may number: eight times those of the largest sensor.
constexpr float kMostRings = 1024;
// Metres; coordinates beyond are other numbers, read as float32. UTM's are below.
constexpr float kFarthest = 2e7F;

// Every `step`-th value from the `first` on, `count` of them.
class Column {
 public:
  Column(const std::string& bytes, uint64_t first, uint64_t step, uint64_t count)
      : start_(bytes.data() + first * sizeof(float)), step_(step * sizeof(float)), count_(count) {}
  uint64_t size() const { return count_; }
  float operator[](uint64_t i) const { return codec::LoadAs<float>(start_ + i * step_); }

 private:
  const char* start_;
  uint64_t step_, count_;
};

bool AreIntensities(const Column& column) {
  uint64_t negative = 0;
  for (uint64_t i = 0; i < column.size(); ++i) negative += column[i] < 0 ? 1 : 0;
  return static_cast<double>(negative) <= kMostNegative * static_cast<double>(column.size());
}

bool AreCoordinates(const Column& column) {
  for (uint64_t i = 0; i < column.size(); ++i) {
    if (std::isfinite(column[i]) && std::abs(column[i]) > kFarthest) return false;
  }
  return true;
}

bool AreWhole(const Column& column, float end) {
  for (uint64_t i = 0; i < column.size(); ++i) {
    const float value = column[i];
    if (!(value >= 0 && value < end && value == std::floor(value))) return false;
  }
  return true;
}

bool StartsPlausibly(const std::string& bytes, uint64_t columns, uint64_t points, bool by_column) {
  const auto column = [&](uint64_t k) {
    return by_column ? Column(bytes, k * points, 1, points) : Column(bytes, k, columns, points);
  };
  return AreIntensities(column(3)) && AreCoordinates(column(0)) && AreCoordinates(column(1)) &&
         AreCoordinates(column(2));
}

std::string RowByRow(const std::string& bytes, uint64_t columns, uint64_t points) {
  std::string rows(bytes.size(), '\0');
  for (uint64_t k = 0; k < columns; ++k) {
    const Column column(bytes, k * points, 1, points);
    for (uint64_t i = 0; i < points; ++i) {
      codec::StoreAs(column[i], rows.data() + (i * columns + k) * sizeof(float));
    }
  }
  return rows;
}

PointPayload Payload(std::string bytes, uint32_t columns, bool has_time) {
  PointPayload payload;
  payload.stride = columns * static_cast<uint32_t>(sizeof(float));
  payload.width = static_cast<uint32_t>(bytes.size() / payload.stride);
  payload.fields = {{"x", 0}, {"y", 4}, {"z", 8}, {"intensity", 12}};
  if (columns > 4) payload.fields.push_back({"ring", 16});
  if (has_time) payload.fields.push_back({"time", 20});
  payload.data = std::move(bytes);
  return payload;
}

}  // namespace

absl::StatusOr<PointPayload> ParseKittiBin(std::string bytes) {
  const uint64_t values = bytes.size() / sizeof(float);
  if (values / 4 > std::numeric_limits<uint32_t>::max()) {
    return absl::InvalidArgumentError("a scan of more than 2^32 points");
  }
  const bool is_whole = bytes.size() % sizeof(float) == 0;
  for (const uint32_t columns : {4U, 5U, 6U}) {
    const uint64_t points = values / columns;
    if (!is_whole || values % columns != 0) continue;
    if (!StartsPlausibly(bytes, columns, points, /*by_column=*/false)) continue;
    if (columns > 4 && !AreWhole(Column(bytes, 4, columns, points), kMostRings)) continue;
    // Whole numbers are labels and the like.
    const bool has_time = columns > 5 && !AreWhole(Column(bytes, 5, columns, points),
                                                   std::numeric_limits<float>::infinity());
    return Payload(std::move(bytes), columns, has_time);
  }
  if (is_whole && values % 4 == 0 && StartsPlausibly(bytes, 4, values / 4, /*by_column=*/true)) {
    return Payload(RowByRow(bytes, 4, values / 4), 4, /*has_time=*/false);
  }
  return absl::InvalidArgumentError(absl::StrCat(
      "no scan of float32 x y z intensity, as KITTI has it: the ", bytes.size(),
      " bytes are not whole points of 4, 5 or 6 columns, or intensities would be negative or rings "
      "no whole numbers. Is the file truncated? If its columns are others, write it as .pcd, whose "
      "header names them"));
}

absl::StatusOr<PointPayload> ReadKittiBin(const std::string& path) {
  absl::StatusOr<std::string> bytes = io::ReadFile(path);
  if (!bytes.ok()) return bytes.status();
  absl::StatusOr<PointPayload> payload = ParseKittiBin(*std::move(bytes));
  if (payload.ok()) return payload;
  return absl::Status(payload.status().code(),
                      absl::StrCat(path, ": ", payload.status().message()));
}

}  // namespace isthmus::formats
