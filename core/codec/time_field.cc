#include "core/codec/time_field.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "core/codec/column.h"
#include "core/codec/payload_layout.h"
#include "core/codec/point_times.h"

namespace isthmus::codec {
namespace {

TimeField Read(const PointPayload& raw, const PointField& field, double unit_s) {
  return {field.name, field.type, unit_s, ReadColumn(raw, field)};
}

std::optional<TimeField> ReadPair(const PointPayload& raw) {
  const PointField* seconds = FindField(raw, {"timestampSec"});
  const PointField* rest = FindField(raw, {"timestampNsec"});
  if (seconds == nullptr || rest == nullptr) return std::nullopt;
  TimeField time{seconds->name + " + " + rest->name, ScalarType::kFloat64, 1,
                 ReadColumn(raw, *seconds)};
  ForEachValue(raw, *rest,
               [&](uint64_t i, auto ns) { time.values[i] += 1e-9 * static_cast<double>(ns); });
  return time;
}

std::optional<TimeField> ReadCurvature(const PointPayload& raw) {
  const PointField* field = FindField(raw, {"curvature"});
  if (field == nullptr) return std::nullopt;
  TimeField time = Read(raw, *field, 1e-3);
  TimeReader reader;
  std::vector<double> values = time.values;
  const bool are_times = reader.Read(time.type, 0, values, time.unit_s) &&
                         IsTurn(reader.last().end_s - reader.last().first_s);
  if (!are_times) return std::nullopt;
  return time;
}

}  // namespace

bool HasEmptyTimes(const PointPayload& raw) {
  const std::optional<TimeField> time = ReadTimeField(raw);
  return time &&
         std::all_of(time->values.begin(), time->values.end(), [](double t) { return t == 0; });
}

std::optional<TimeField> ReadTimeField(const PointPayload& raw) {
  if (const PointField* field = FindPlainTimeField(raw)) return Read(raw, *field, 0);
  if (const PointField* field = FindField(raw, {"time_offset_ns"})) return Read(raw, *field, 1e-9);
  if (std::optional<TimeField> pair = ReadPair(raw)) return pair;
  return ReadCurvature(raw);
}

void ClearTimes(PointPayload& raw) {
  const uint64_t points = PointCount(raw);
  if (const PointField* field = FindPlainTimeField(raw)) {
    for (uint64_t i = 0; i < points; ++i) {
      std::memset(raw.data.data() + i * raw.stride + field->offset, 0, SizeOf(field->type));
    }
    return;
  }
  const uint32_t stride = raw.stride + sizeof(float);
  std::string data(points * stride, '\0');
  for (uint64_t i = 0; i < points; ++i) {
    std::memcpy(data.data() + i * stride, raw.data.data() + i * raw.stride, raw.stride);
  }
  raw.fields.push_back({"time", raw.stride, ScalarType::kFloat32});
  raw.stride = stride;
  raw.data = std::move(data);
}

void DropTimes(PointPayload& raw) {
  while (const std::optional<TimeField> time = ReadTimeField(raw)) {
    std::erase_if(raw.fields, [&](const PointField& field) {
      return field.name == time->name || time->name.starts_with(field.name + " + ");
    });
  }
}

}  // namespace isthmus::codec
