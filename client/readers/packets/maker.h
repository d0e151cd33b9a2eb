// The maker of a sensor, as its packets tell, and the decoder for them.
#pragma once

#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "client/readers/packets/packet_decoder.h"
#include "client/readers/recording.h"

namespace isthmus::readers {

enum class Maker : uint8_t { kVelodyne, kOuster, kHesai, kLivox, kRobosense };

const char* PacketsOf(Maker maker);  // "Velodyne packets"

// The maker of a packet that has `length` bytes and begins like this; empty for what is no point
// data of any.
std::optional<Maker> MakerOf(absl::string_view beginning, size_t length);

// The maker of the sensor that somebody named. InvalidArgument for one of none.
absl::StatusOr<Maker> MakerOfSensor(const std::string& sensor);

// A decoder as the options say, with the files that they name: NotFound where one is not there.
// Without metadata, Ouster's is the .json beside `capture` with its stem, else the only one in its
// folder that tells of packets of `packet_bytes` (0: of any); InvalidArgument, saying what to give,
// if there is none. `capture` is empty for a live sensor.
absl::StatusOr<std::unique_ptr<PacketDecoder>> MakeDecoder(Maker maker, const ReadOptions& options,
                                                           std::optional<int64_t> utc_offset_ns,
                                                           const std::string& capture,
                                                           size_t packet_bytes);

// The decoder for packets like this one; null for one of no known maker, and for Ouster's, which
// need metadata.
absl::StatusOr<std::unique_ptr<PacketDecoder>> MakeDecoderOf(absl::string_view packet,
                                                             const PacketOptions& options);

inline constexpr char kKnownMakers[] = "Velodyne's, Ouster's, Hesai's, Livox' or RoboSense's";

}  // namespace isthmus::readers
