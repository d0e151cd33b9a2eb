// Payloads and clouds that several tests of the codecs use.
#pragma once

#include <cmath>
#include <cstring>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "core/point_payload.h"
#include "core/scan.h"

namespace isthmus::codec {

// Builds a raw payload column by column: PayloadOf(n).Add<float>("x", kFloat32, [](i) { ... }).
class PayloadOf {
 public:
  explicit PayloadOf(uint32_t width, uint32_t height = 1) : width_(width), height_(height) {}

  template <typename T, typename F>
  PayloadOf& Add(const std::string& name, ScalarType type, const F& value_of) {
    PayloadOf& self = *this;
    const uint32_t n = width_ * height_;
    std::string column;
    for (uint32_t i = 0; i < n; ++i) {
      const T value = static_cast<T>(value_of(i));
      column.append(reinterpret_cast<const char*>(&value), sizeof(T));
    }
    columns_.push_back({name, type, std::move(column)});
    return self;
  }

  PointPayload Build() const {
    PointPayload payload;
    payload.width = width_;
    payload.height = height_;
    for (const Column& column : columns_) {
      payload.fields.push_back({column.name, payload.stride, column.type});
      payload.stride += SizeOf(column.type);
    }
    for (uint32_t i = 0; i < width_ * height_; ++i) {
      for (const Column& column : columns_) {
        payload.data += column.bytes.substr(i * SizeOf(column.type), SizeOf(column.type));
      }
    }
    return payload;
  }

 private:
  struct Column {
    std::string name;
    ScalarType type;
    std::string bytes;
  };
  const uint32_t width_, height_;
  std::vector<Column> columns_;
};

// One turn of a sensor with 16 rings in a room of 20 x 12 m, column by column, 0.1 s.
inline std::vector<ScanPoint> RoomScan(int columns = 400) {
  std::mt19937 random(7);
  std::normal_distribution<float> noise(0, 0.02f);
  std::vector<ScanPoint> points;
  for (int c = 0; c < columns; ++c) {
    const float azimuth = 6.2831853f * static_cast<float>(c) / static_cast<float>(columns);
    for (int ring = 0; ring < 16; ++ring) {
      const float elevation = (-15.0f + 2.0f * static_cast<float>(ring)) * 0.0174533f;
      const float wall = std::min(10.0f / std::max(0.01f, std::abs(std::cos(azimuth))),
                                  6.0f / std::max(0.01f, std::abs(std::sin(azimuth))));
      const float range = wall / std::cos(elevation) + noise(random);
      ScanPoint p;
      p.x = range * std::cos(elevation) * std::cos(azimuth);
      p.y = range * std::cos(elevation) * std::sin(azimuth);
      p.z = range * std::sin(elevation);
      p.intensity = static_cast<float>((c * 7 + ring * 3) % 256);
      p.time = -0.1f * static_cast<float>(columns - 1 - c) / static_cast<float>(columns);
      p.ring = static_cast<uint16_t>(ring);
      points.push_back(p);
    }
  }
  return points;
}

}  // namespace isthmus::codec
