#include "core/formats/las_writer.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <absl/time/civil_time.h>
#include <absl/time/time.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <iterator>
#include <limits>
#include <utility>

#include "core/codec/column.h"

namespace isthmus::formats {
namespace {

// Table 3, public header block, and section 2.5, variable length records.
constexpr uint16_t kLasHeaderSize = 375;
constexpr uint16_t kWktBit = 1 << 4;  // In the global encoding: required with formats 6 to 10.
constexpr uint8_t kPointFormat = 6, kOnlyReturn = 1 << 4 | 1;
constexpr uint16_t kLookup = 0, kTextArea = 3,
                   kWktRecord = 2112;  // Record ids, section 3 and table 22.
constexpr double kStepM = 0.001;

// Table 17, in order of PointClass; names of those that are not the standard's, which begin at 64.
struct LasClass {
  uint8_t number;
  const char* name;  // 15 bytes at most.
};
constexpr std::array<LasClass, kPointClasses> kLasClasses = {{{1, nullptr},
                                                              {2, nullptr},
                                                              {64, "ceiling"},
                                                              {6, nullptr},
                                                              {65, "pole"},
                                                              {5, nullptr},
                                                              {66, "vehicle"},
                                                              {67, "object"},
                                                              {68, "structure"},
                                                              {69, "mover"}}};

template <typename T>
void Put(T value, std::string* out) {
  char bytes[sizeof(T)];
  codec::StoreAs(value, bytes);
  out->append(bytes, sizeof(T));
}

void PutText(const std::string& text, size_t width, std::string* out) {
  std::string field = text.substr(0, width);
  field.resize(width, '\0');
  out->append(field);
}

void PutRecord(const std::string& user, uint16_t id, const std::string& what,
               const std::string& data, std::string* out) {
  Put<uint16_t>(0, out);
  PutText(user, 16, out);
  Put(id, out);
  Put(static_cast<uint16_t>(data.size()), out);
  PutText(what, 32, out);
  out->append(data);
}

// Section 3, Classification Lookup: 256 numbers with their names.
std::string LookupOfClasses() {
  std::string names[256];
  for (const LasClass& of : kLasClasses) {
    if (of.name != nullptr) names[of.number] = of.name;
  }
  std::string lookup;
  for (size_t i = 0; i < std::size(names); ++i) {
    Put(static_cast<uint8_t>(i), &lookup);
    PutText(names[i], 15, &lookup);
  }
  return lookup;
}

// The facts that a person needs to read the points; of one length, whatever the factor.
std::string TextOf(const std::vector<RobotId>& robots, float factor) {
  std::string text = absl::StrFormat("intensity is %5.0f times what sensors gave\n", factor);
  for (size_t i = 0; i < robots.size(); ++i) {
    const std::string line = absl::StrCat("point source ", i + 1, ": ", robots[i].value(), "\n");
    // A record ends at 65535 bytes, its final zero included.
    if (text.size() + line.size() >= std::numeric_limits<uint16_t>::max()) break;
    text += line;
  }
  text.push_back('\0');
  return text;
}

}  // namespace

LasWriter::LasWriter(LasOptions options) : options_(std::move(options)) {
  min_.setZero();
  max_.setZero();
}

std::string LasWriter::Header() const {
  std::string records;
  PutRecord("LASF_Spec", kTextArea, "Robots and intensity",
            TextOf(options_.robots, intensity_factor_), &records);
  PutRecord("LASF_Spec", kLookup, "Classes", LookupOfClasses(), &records);
  if (!options_.wkt.empty()) {
    PutRecord("LASF_Projection", kWktRecord, "Coordinate system", options_.wkt + '\0', &records);
  }
  const absl::CivilDay day =
      absl::ToCivilDay(absl::FromUnixNanos(options_.created_ns), absl::UTCTimeZone());
  std::string out = "LASF";
  Put<uint16_t>(0, &out);
  Put(kWktBit, &out);
  PutText("", 16, &out);  // Project id.
  Put<uint8_t>(1, &out);
  Put<uint8_t>(4, &out);
  PutText("MERGE", 32, &out);  // System identifier: several files' points together.
  PutText(options_.software.substr(0, 31), 32, &out);
  Put(static_cast<uint16_t>(absl::GetYearDay(day)), &out);
  Put(static_cast<uint16_t>(day.year()), &out);
  Put(kLasHeaderSize, &out);
  Put(static_cast<uint32_t>(kLasHeaderSize + records.size()), &out);
  Put<uint32_t>(options_.wkt.empty() ? 2 : 3, &out);
  Put(kPointFormat, &out);
  Put(static_cast<uint16_t>(kRecordSize), &out);
  out.append(6 * sizeof(uint32_t), '\0');  // Legacy counts, 0 with formats 6 to 10.
  for (int axis = 0; axis < 3; ++axis) Put(kStepM, &out);
  for (int axis = 0; axis < 3; ++axis) Put(options_.offset[axis], &out);
  for (int axis = 0; axis < 3; ++axis) {
    Put(max_[axis] * kStepM + options_.offset[axis], &out);
    Put(min_[axis] * kStepM + options_.offset[axis], &out);
  }
  out.append(2 * sizeof(uint64_t) + sizeof(uint32_t), '\0');  // No waveforms, no extended records.
  Put(count_, &out);
  Put(count_, &out);  // All are first returns, none a later one.
  out.append(14 * sizeof(uint64_t), '\0');
  return out + records;
}

void LasWriter::ChooseFactor(const std::vector<MapPoint>& points) {
  if (intensity_factor_ > 0 || points.empty()) return;
  float largest = 0;
  for (const MapPoint& point : points) largest = std::max(largest, point.intensity);
  intensity_factor_ = largest <= 1 ? 65535.0F : largest <= 255 ? 257.0F : 1.0F;
}

void LasWriter::Append(const Eigen::Vector3d& position, const MapPoint& point,
                       std::string* records) {
  const Eigen::Array3d steps = ((position - options_.offset).array() / kStepM).round();
  constexpr double kMost = std::numeric_limits<int32_t>::max();
  if (!(steps.abs() <= kMost).all()) return;
  min_ = count_ == 0 ? steps : min_.min(steps);
  max_ = count_ == 0 ? steps : max_.max(steps);
  ++count_;
  for (int axis = 0; axis < 3; ++axis) Put(static_cast<int32_t>(steps[axis]), records);
  // Written so that NaN becomes 0.
  const float scaled = std::fmin(std::fmax(point.intensity * intensity_factor_, 0.0F), 65535.0F);
  Put(static_cast<uint16_t>(std::lround(scaled)), records);
  Put(kOnlyReturn, records);
  Put<uint8_t>(0, records);  // Neither synthetic, withheld nor at the edge of a scan line.
  Put(kLasClasses[static_cast<size_t>(point.label)].number, records);
  Put<uint8_t>(0, records);  // User data.
  Put<int16_t>(0, records);  // Scan angle.
  Put(static_cast<uint16_t>(std::min(point.robot, 65534u) + 1), records);
  Put<double>(0, records);  // GPS time.
}

}  // namespace isthmus::formats
