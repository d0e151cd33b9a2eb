#include "tests/client/readers/packets/packet_writer.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <absl/strings/str_join.h>
#include <arpa/inet.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

namespace isthmus::readers::testing {
namespace {

std::string Address(const std::string& text) {
  std::string bytes(16, '\0');
  if (inet_pton(AF_INET, text.c_str(), bytes.data()) == 1) {
    bytes.resize(4);
  } else {
    EXPECT_EQ(inet_pton(AF_INET6, text.c_str(), bytes.data()), 1) << text;
  }
  return bytes;
}

std::string LinkHeader(Link link, bool v6) {
  std::string bytes;
  const uint64_t type = v6 ? 0x86DD : 0x0800;
  switch (link) {
    case Link::kEthernet:
      bytes.append(12, '\x02');
      AppendBig(bytes, type, 2);
      break;
    case Link::kVlan:
      bytes.append(12, '\x02');
      AppendBig(bytes, 0x88A80001, 4);
      AppendBig(bytes, 0x81000007, 4);
      AppendBig(bytes, type, 2);
      break;
    case Link::kCooked:
      bytes.append(14, '\0');
      AppendBig(bytes, type, 2);
      break;
    case Link::kCooked2:
      AppendBig(bytes, type, 2);
      bytes.append(18, '\0');
      break;
    case Link::kLoopback:
      Append(bytes, v6 ? 10 : 2, 4);
      break;
    case Link::kRaw:
      break;
  }
  return bytes;
}

std::string IpHeader(const Sender& sender, size_t size, size_t offset, bool more, bool fragment) {
  const std::string source = Address(sender.address);
  std::string bytes;
  if (source.size() == 4) {
    AppendBig(bytes, 0x4500, 2);
    AppendBig(bytes, 20 + size, 2);
    AppendBig(bytes, 77, 2);
    AppendBig(bytes, (more ? 0x2000 : 0) | offset / 8, 2);
    AppendBig(bytes, 0x4011, 2);
    AppendBig(bytes, 0, 2);
    return bytes + source + Address("255.255.255.255");
  }
  AppendBig(bytes, 0x60000000, 4);
  AppendBig(bytes, size + (fragment ? 8 : 0), 2);
  AppendBig(bytes, fragment ? 44 : 17, 1);
  AppendBig(bytes, 64, 1);
  bytes += source + Address("ff02::1");
  if (fragment) {
    AppendBig(bytes, 17 << 8, 2);
    AppendBig(bytes, offset | (more ? 1 : 0), 2);
    AppendBig(bytes, 77, 4);
  }
  return bytes;
}

void AppendPixel(std::string& bytes, const OusterSource& source, int column, int row) {
  const uint32_t range = source.range(column, row, 0);
  const uint64_t reflectivity = static_cast<uint64_t>(row) + 1;
  const uint64_t signal = 1000 + static_cast<uint64_t>(row), near_ir = 160;
  if (source.profile == "RNG15_RFL8_NIR8") {
    Append(bytes, range / 8, 2);
    Append(bytes, reflectivity, 1);
    Append(bytes, near_ir / 16, 1);
  } else if (source.profile == "RNG19_RFL8_SIG16_NIR16_DUAL") {
    for (int which : {0, 1}) {
      Append(bytes, source.range(column, row, which), 3);
      Append(bytes, reflectivity, 1);
    }
    Append(bytes, signal, 2);
    Append(bytes, signal, 2);
    Append(bytes, near_ir, 2);
    Append(bytes, 0, 2);
  } else {
    const bool legacy = source.profile == "LEGACY";
    Append(bytes, range, 4);
    Append(bytes, reflectivity, legacy ? 2 : 1);
    if (!legacy) Append(bytes, 0, 1);
    Append(bytes, signal, 2);
    Append(bytes, near_ir, 2);
    Append(bytes, 0, 2);
  }
}

}  // namespace

void Append(std::string& bytes, uint64_t value, int size) {
  for (int i = 0; i < size; ++i) bytes += static_cast<char>(value >> (8 * i));
}

void AppendBig(std::string& bytes, uint64_t value, int size) {
  for (int i = size - 1; i >= 0; --i) bytes += static_cast<char>(value >> (8 * i));
}

std::string VelodynePacket(const std::array<VelodyneBlock, 12>& blocks, uint32_t microseconds,
                           uint8_t return_mode, uint8_t product) {
  std::string bytes;
  for (const VelodyneBlock& block : blocks) {
    Append(bytes, block.flag, 2);
    Append(bytes, static_cast<uint64_t>(block.azimuth), 2);
    for (size_t laser = 0; laser < 32; ++laser) {
      Append(bytes, block.ranges[laser], 2);
      Append(bytes, block.intensities[laser], 1);
    }
  }
  Append(bytes, microseconds, 4);
  Append(bytes, return_mode, 1);
  Append(bytes, product, 1);
  return bytes;
}

int64_t VelodyneTimeNs(const VelodyneSource& source, int index) {
  const double firings = 12.0 / source.blocks_per_firing;
  return static_cast<int64_t>(std::floor(index * firings * source.firing_us)) * 1000;
}

std::string VelodynePacketOf(const VelodyneSource& source, int index, double start_us) {
  std::array<VelodyneBlock, 12> blocks;
  const int firings = 12 / source.blocks_per_firing;
  for (int b = 0; b < 12; ++b) {
    VelodyneBlock& block = blocks[static_cast<size_t>(b)];
    const int firing = index * firings + b / source.blocks_per_firing;
    block.azimuth = static_cast<int>(int64_t{firing} * source.step % 36000);
    if (source.two_banks && b % 2 == 1) block.flag = 0xDDFF;
    const int banks = source.two_banks ? 2 : 1;
    const int which = source.blocks_per_firing > banks ? b / banks % 2 : 0;
    for (int laser = 0; laser < 32; ++laser) {
      block.ranges[static_cast<size_t>(laser)] = source.range(b, laser, which);
      block.intensities[static_cast<size_t>(laser)] = static_cast<uint8_t>(10 + laser);
    }
  }
  const double time_us = start_us + static_cast<double>(VelodyneTimeNs(source, index)) * 1e-3;
  const double hour_us = 3600e6;
  return VelodynePacket(blocks, static_cast<uint32_t>(std::fmod(time_us, hour_us)),
                        source.return_mode, source.product);
}

std::string PositionPacketOf(uint32_t microseconds, const std::string& sentence) {
  std::string bytes(198, '\0');
  Append(bytes, microseconds, 4);
  Append(bytes, 2, 1);
  bytes.append(3, '\0');
  uint8_t sum = 0;
  for (const char c : sentence) sum ^= static_cast<uint8_t>(c);
  absl::StrAppendFormat(&bytes, "$%s*%02X\r\n", sentence, sum);
  bytes.resize(512);
  return bytes;
}

std::string OusterPacket(const OusterSource& source, int first_column) {
  const bool legacy = source.profile == "LEGACY";
  std::string bytes;
  if (!legacy) {
    Append(bytes, 1, 2);
    Append(bytes, source.frame, 2);
    Append(bytes, source.start, 3);
    Append(bytes, source.serial, 5);
    bytes.append(20, '\0');
  }
  for (int column = first_column; column < first_column + 16; ++column) {
    Append(bytes, source.start_ns + source.column_ns * static_cast<uint64_t>(column), 8);
    Append(bytes, static_cast<uint64_t>(column), 2);
    const bool valid = source.valid(column);
    if (legacy) {
      Append(bytes, source.frame, 2);
      Append(bytes, 0, 4);
    } else {
      Append(bytes, valid ? 1 : 0, 2);
    }
    for (int row = 0; row < source.rows; ++row) AppendPixel(bytes, source, column, row);
    if (legacy) Append(bytes, valid ? 0xFFFFFFFF : 0, 4);
  }
  if (!legacy) bytes.append(32, '\0');
  return bytes;
}

std::string OusterMetadata(const OusterSource& source, bool nested) {
  std::vector<std::string> altitudes, azimuths;
  for (int row = 0; row < source.rows; ++row) {
    altitudes.push_back(absl::StrCat(20.0 - 40.0 * row / (source.rows - 1)));
    azimuths.push_back(row % 2 == 0 ? "4.25" : "-1.42");
  }
  const std::string beams =
      absl::StrCat("\"beam_altitude_angles\": [", absl::StrJoin(altitudes, ","),
                   "], \"beam_azimuth_angles\": [", absl::StrJoin(azimuths, ","), "], ");
  const std::string format =
      absl::StrCat("{\"columns_per_frame\": ", source.columns, ", \"columns_per_packet\": 16, ",
                   "\"pixels_per_column\": ", source.rows, ", \"udp_profile_lidar\": \"",
                   source.profile, "\", \"column_window\": [0, ", source.columns - 1, "]}");
  const std::string transform =
      "\"lidar_to_sensor_transform\": [-1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1, 36.18, 0, 0, 0, 1]";
  const std::string serial =
      source.told_serial == 0 ? "" : absl::StrCat(", \"prod_sn\": \"", source.told_serial, "\"");
  const std::string start =
      source.told_start == 0 ? "" : absl::StrCat(", \"initialization_id\": ", source.told_start);
  const std::string unit = "\"prod_line\": \"OS-1-16\"" + serial + start;
  if (!nested) {
    return absl::StrCat("{", beams,
                        "\"lidar_origin_to_beam_origin_mm\": 15.8, \"data_format\": ", format, ", ",
                        unit, ", ", transform, "}");
  }
  return absl::StrCat(
      "{\"beam_intrinsics\": {", beams,
      "\"beam_to_lidar_transform\": [1, 0, 0, 15.8, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]}, "
      "\"lidar_data_format\": ",
      format, ", \"sensor_info\": {", unit, "}, \"lidar_intrinsics\": {", transform,
      "}, \"config_params\": {\"timestamp_mode\": \"TIME_FROM_INTERNAL_OSC\"}}");
}

std::vector<std::string> Frames(Link link, const Sender& sender, const std::string& payload,
                                size_t mtu) {
  std::string datagram;
  AppendBig(datagram, 2368, 2);
  AppendBig(datagram, sender.port, 2);
  AppendBig(datagram, payload.size() + 8, 2);
  AppendBig(datagram, 0, 2);
  datagram += payload;
  const bool v6 = Address(sender.address).size() == 16;
  const size_t piece = (mtu - 48) / 8 * 8;
  const bool fragment = datagram.size() > piece;
  std::vector<std::string> frames;
  for (size_t offset = 0; offset < datagram.size(); offset += piece) {
    const std::string part = datagram.substr(offset, piece);
    const bool more = offset + part.size() < datagram.size();
    frames.push_back(LinkHeader(link, v6) + IpHeader(sender, part.size(), offset, more, fragment) +
                     part);
  }
  return frames;
}

CaptureWriter::CaptureWriter(Link link) : link_(link) {
  const uint64_t types[] = {1, 1, 113, 276, 0, 101};
  Append(bytes_, 0xA1B23C4D, 4);
  Append(bytes_, 2, 2);
  Append(bytes_, 4, 2);
  Append(bytes_, 0, 8);
  Append(bytes_, 65535, 4);
  Append(bytes_, types[static_cast<int>(link)], 4);
}

void CaptureWriter::Add(const std::string& frame, int64_t arrival_ns) {
  Append(bytes_, static_cast<uint64_t>(arrival_ns / 1'000'000'000), 4);
  Append(bytes_, static_cast<uint64_t>(arrival_ns % 1'000'000'000), 4);
  Append(bytes_, frame.size(), 4);
  Append(bytes_, frame.size(), 4);
  bytes_ += frame;
}

void CaptureWriter::Add(const Sender& sender, const std::string& payload, int64_t arrival_ns,
                        size_t mtu) {
  for (const std::string& frame : Frames(link_, sender, payload, mtu)) Add(frame, arrival_ns);
}

std::string WriteTestFile(const std::string& name, const std::string& bytes) {
  const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
  std::string folder = absl::StrCat(test->test_suite_name(), "_", test->name());
  std::replace(folder.begin(), folder.end(), '/', '_');
  const std::filesystem::path path = std::filesystem::path(::testing::TempDir()) / folder / name;
  static std::string last_folder;
  if (folder != last_folder) std::filesystem::remove_all(path.parent_path());
  last_folder = folder;
  std::filesystem::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary) << bytes;
  return path;
}

}  // namespace isthmus::readers::testing
