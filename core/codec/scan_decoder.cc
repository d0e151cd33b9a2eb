#include "core/codec/scan_decoder.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "core/codec/column.h"
#include "core/codec/payload_layout.h"
#include "core/codec/quantized.h"
#include "core/codec/ring_lines.h"
#include "core/codec/time_field.h"

namespace isthmus::codec {
namespace {

// Enough to tell a correlation of -0.5 from none.
constexpr size_t kRingSamples = 4096;

// Lines of an organised cloud that may be rings: what odometry supports.
constexpr uint32_t kMostRings = 1024;

absl::Status ReadPositions(const PointPayload& raw, std::vector<ScanPoint>& points) {
  const PointField* x = FindField(raw, {"x"});
  const PointField* y = FindField(raw, {"y"});
  const PointField* z = FindField(raw, {"z"});
  if (x == nullptr || y == nullptr || z == nullptr) {
    std::string names;
    for (const PointField& field : raw.fields) absl::StrAppend(&names, " ", field.name);
    return absl::InvalidArgumentError(
        absl::StrCat("a scan needs the fields x, y and z; this one has:", names));
  }
  points.resize(PointCount(raw));
  ForEachValue(raw, *x, [&](uint64_t i, auto v) { points[i].x = static_cast<float>(v); });
  ForEachValue(raw, *y, [&](uint64_t i, auto v) { points[i].y = static_cast<float>(v); });
  ForEachValue(raw, *z, [&](uint64_t i, auto v) { points[i].z = static_cast<float>(v); });
  return absl::OkStatus();
}

void ReadIntensities(const PointPayload& raw, std::vector<ScanPoint>& points) {
  const PointField* field = FindField(raw, {"intensity", "i", "reflectivity", "signal"});
  if (field == nullptr) return;
  ForEachValue(raw, *field, [&](uint64_t i, auto v) {
    const auto intensity = static_cast<float>(v);
    points[i].intensity = std::isfinite(intensity) ? intensity : 0;
  });
}

// The number of rings that an organised cloud has by its rows, or its columns, whichever keep to
// one value of the field `ring`; 0 where it is not organised or its values are more.
uint32_t LinesOfField(const PointPayload& raw, const std::vector<ScanPoint>& points) {
  if (raw.height < 2) return 0;
  uint64_t along = 0, pairs = 0;
  uint32_t top = 0;
  for (uint64_t i = 0; i < points.size(); ++i) {
    if (!IsReturn(points[i])) continue;
    top = std::max<uint32_t>(top, points[i].ring);
    if ((i + 1) % raw.width == 0 || !IsReturn(points[i + 1])) continue;
    ++pairs;
    along += points[i].ring == points[i + 1].ring ? 1 : 0;
  }
  const uint32_t lines = 2 * along > pairs ? raw.height : raw.width;
  return lines > top && lines <= kMostRings ? lines : 0;
}

// Rings of no-returns are not looked at: drivers fill them with anything. `lines` is the number of
// rings, where an organised cloud tells; else 0.
absl::Status ReadRings(const PointPayload& raw, Scan& scan, std::string& source, uint32_t& lines) {
  const PointField* field = FindRingField(raw);
  if (field == nullptr) {
    const auto rings = FindRingLines(raw.width, raw.height, scan.points);
    scan.has_ring = rings.has_value();
    if (!rings) return absl::OkStatus();
    source = rings->are_rows ? "rows of the cloud" : "columns of the cloud";
    lines = rings->count;
    for (uint64_t i = 0; i < scan.points.size(); ++i) {
      scan.points[i].ring = rings->RingOf(i, raw.width);
    }
    return absl::OkStatus();
  }
  bool in_range = true;
  ForEachValue(raw, *field, [&](uint64_t i, auto value) {
    const auto ring = static_cast<double>(value);
    if (ring >= 0 && ring <= 65535) {
      scan.points[i].ring = static_cast<uint16_t>(ring);
    } else if (IsReturn(scan.points[i])) {
      in_range = false;
    }
  });
  scan.has_ring = true;
  source = absl::StrCat("field '", field->name, "'");
  lines = LinesOfField(raw, scan.points);
  if (in_range) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat("field '", field->name, "' holds a ring outside [0, 65535]"));
}

// Keeps the points for which `keep(i)` holds, and their times.
template <typename Keep>
void KeepPoints(std::vector<ScanPoint>& points, std::vector<double>& times, const Keep& keep) {
  size_t kept = 0;
  for (size_t i = 0; i < points.size(); ++i) {
    if (!keep(i)) continue;
    if (kept != i) {
      points[kept] = points[i];
      if (!times.empty()) times[kept] = times[i];
    }
    ++kept;
  }
  points.resize(kept);
  if (!times.empty()) times.resize(kept);
}

// Correlation of ring and elevation, in [-1, 1], of some thousand points of all rings.
double RingElevationCorrelation(const std::vector<ScanPoint>& points) {
  double sum_r = 0, sum_e = 0, sum_rr = 0, sum_ee = 0, sum_re = 0;
  const size_t n_points = points.size();
  const size_t samples = std::min(n_points, kRingSamples);
  // Steps of the golden section meet all rings alike, however they are interleaved.
  const auto step = static_cast<size_t>(0.6180339887 * static_cast<double>(n_points)) | 1;
  for (size_t k = 0, i = 0; k < samples; ++k, i = (i + step) % n_points) {
    const ScanPoint& p = points[i];
    const double e = p.z / std::sqrt(p.x * p.x + p.y * p.y + p.z * p.z);
    const double r = p.ring;
    sum_r += r;
    sum_e += e;
    sum_rr += r * r;
    sum_ee += e * e;
    sum_re += r * e;
  }
  const auto n = static_cast<double>(samples);
  const double var_r = sum_rr - sum_r * sum_r / n;
  const double var_e = sum_ee - sum_e * sum_e / n;
  const double product = var_r * var_e;
  return product > 0 ? (sum_re - sum_r * sum_e / n) / std::sqrt(product) : 0;
}

// Makes ring 0 the lowest. The number of rings is that of the lines or, where these do not tell
// (0), the next power of two, so that it does not change from scan to scan when the outermost ring
// sees nothing.
void TurnRings(uint32_t lines, std::vector<ScanPoint>& points) {
  if (RingElevationCorrelation(points) > -0.5) return;
  uint32_t top = 0;
  for (const ScanPoint& p : points) top = std::max<uint32_t>(top, p.ring);
  const uint32_t rings = lines > top ? lines : std::bit_ceil(top + 1);
  for (ScanPoint& p : points) p.ring = static_cast<uint16_t>(rings - 1 - p.ring);
}

}  // namespace

absl::StatusOr<Scan> ScanDecoder::DecodeRaw(const PointPayload& raw, int64_t end_stamp_ns) {
  Scan scan;
  ScanFields fields;
  if (auto status = ReadPositions(raw, scan.points); !status.ok()) return status;
  ReadIntensities(raw, scan.points);
  uint32_t lines = 0;
  if (auto status = ReadRings(raw, scan, fields.ring, lines); !status.ok()) return status;
  std::optional<TimeField> time = ReadTimeField(raw);
  std::vector<double> times;
  if (time) times = std::move(time->values);

  KeepPoints(scan.points, times, [&](size_t i) { return IsReturn(scan.points[i]); });
  if (scan.points.empty()) {
    return absl::InvalidArgumentError(absl::StrCat(
        "the scan holds no returns: all of its ", PointCount(raw),
        " points are not finite, at zero range or beyond 100 km; is the sensor covered?"));
  }
  if (scan.has_ring) TurnRings(lines, scan.points);
  scan.has_time = time && times_.Read(time->type, end_stamp_ns, times, time->unit_s);
  if (scan.has_time) {
    if (times_.last().odd > 0) {
      odd_times_ += times_.last().odd;
      KeepPoints(scan.points, times, [&](size_t i) { return !std::isnan(times[i]); });
    }
    for (size_t i = 0; i < times.size(); ++i) scan.points[i].time = static_cast<float>(times[i]);
    fields.time = absl::StrCat("field '", time->name, "' (", times_.Description(), ")");
    if (odd_times_ > 0) {
      absl::StrAppend(&fields.time, ", ", odd_times_, " points left out for odd times");
    }
  }
  fields_ = std::move(fields);
  return scan;
}

absl::StatusOr<Scan> ScanDecoder::Decode(const PointPayload& payload, uint64_t sequence,
                                         int64_t end_stamp_ns) {
  if (absl::Status status = CheckLayout(payload); !status.ok()) return status;
  absl::StatusOr<Scan> scan;
  if (payload.encoding == PayloadEncoding::kQuantized) {
    absl::StatusOr<PointPayload> raw = Dequantize(payload);
    if (!raw.ok()) return raw.status();
    scan = DecodeRaw(*raw, end_stamp_ns);
  } else {
    scan = DecodeRaw(payload, end_stamp_ns);
  }
  if (!scan.ok()) return scan.status();
  scan->sequence = sequence;
  scan->end_stamp_ns = end_stamp_ns;
  return scan;
}

absl::StatusOr<Scan> DecodeScan(const PointPayload& payload, uint64_t sequence,
                                int64_t end_stamp_ns) {
  return ScanDecoder().Decode(payload, sequence, end_stamp_ns);
}

}  // namespace isthmus::codec
