// Packets of sensors and the captures they lie in, written by the manuals of the formats for tests.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace isthmus::readers::testing {

// Little endian, appended; and big endian.
void Append(std::string& bytes, uint64_t value, int size);
void AppendBig(std::string& bytes, uint64_t value, int size);

// A Velodyne packet, block by block.
struct VelodyneBlock {
  uint16_t flag = 0xEEFF;
  int azimuth = 0;                       // Hundredths of a degree.
  std::array<uint16_t, 32> ranges = {};  // As sent.
  std::array<uint8_t, 32> intensities = {};
};
std::string VelodynePacket(const std::array<VelodyneBlock, 12>& blocks, uint32_t microseconds,
                           uint8_t return_mode, uint8_t product);

// A model's packets, by its manual, and its measurements.
struct VelodyneSource {
  uint8_t return_mode = 0x37, product = 0x22;
  int blocks_per_firing = 1;   // Blocks that share an azimuth.
  bool two_banks = false;      // HDL-64E: blocks take turns between the banks.
  double firing_us = 110.592;  // From azimuth to azimuth.
  int step = 40;               // Hundredths of a degree from azimuth to azimuth.
  // As sent, for block in the packet, laser in the block and return (0, 1).
  std::function<uint16_t(int, int, int)> range = [](int, int, int) { return uint16_t{5000}; };
};

// Packet `index` of a sensor that starts at azimuth 0 and that microsecond of the hour.
std::string VelodynePacketOf(const VelodyneSource& source, int index, double start_us);
// Nanoseconds that packet `index` is stamped after the first one.
int64_t VelodyneTimeNs(const VelodyneSource& source, int index);

// 512 bytes; the sentence gets its checksum.
std::string PositionPacketOf(uint32_t microseconds, const std::string& sentence);

// A packet of an Ouster sensor of 16 columns.
struct OusterSource {
  std::string profile = "RNG19_RFL8_SIG16_NIR16";
  int rows = 16, columns = 64;  // In a frame.
  uint16_t frame = 1;
  // Numbers of the unit and its start, in packets and metadata; 0: left out of the metadata.
  uint64_t serial = 0, told_serial = 0;
  uint32_t start = 0, told_start = 0;
  uint64_t start_ns = 0;           // Column 0's.
  uint64_t column_ns = 1'000'000;  // From one to the next.
  std::function<bool(int)> valid = [](int) { return true; };
  // Millimetres, by column of the frame, row and return.
  std::function<uint32_t(int, int, int)> range = [](int, int, int) { return 8000u; };
};
std::string OusterPacket(const OusterSource& source, int first_column);
// Its metadata: flat, or nested as of newer firmware.
std::string OusterMetadata(const OusterSource& source, bool nested);

// Frames and captures.
enum class Link { kEthernet, kVlan, kCooked, kCooked2, kLoopback, kRaw };
struct Sender {
  std::string address = "192.168.1.201";  // IPv4 or IPv6.
  uint16_t port = 2368;                   // Destination port.
};
// The frames of a datagram: more than one where it is longer than `mtu`.
std::vector<std::string> Frames(Link link, const Sender& sender, const std::string& payload,
                                size_t mtu = 65535);

// A .pcap with nanoseconds.
class CaptureWriter {
 public:
  explicit CaptureWriter(Link link);
  void Add(const std::string& frame, int64_t arrival_ns);
  void Add(const Sender& sender, const std::string& payload, int64_t arrival_ns,
           size_t mtu = 65535);
  const std::string& bytes() const { return bytes_; }

 private:
  Link link_;
  std::string bytes_;
};

// Writes it to a file of the test; returns the path.
std::string WriteTestFile(const std::string& name, const std::string& bytes);

}  // namespace isthmus::readers::testing
