// A data packet of a Velodyne sensor: 12 blocks of 32 measurements, the clock, and who sent it.
// VLP-16 User Manual (63-9243 Rev. E) 9.3, VLP-32C User Manual (63-9325 Rev. B) 9.3, HDL-32E User
// Manual (63-9113 Rev. M) appendix, HDL-64E S3 User's Manual (63-HDL64ES3 Rev. K) appendix E,
// VLS-128 User Manual (63-9483 Rev. 2) 9.3.
#pragma once

#include <absl/status/status.h>
#include <absl/strings/string_view.h>

#include <cstdint>
#include <optional>

#include "core/codec/column.h"

namespace isthmus::readers::velodyne {

inline constexpr int kBlocks = 12;            // Format
inline constexpr int kLasersPerBlock = 32;    // Format
inline constexpr int kBlockBytes = 100;       // Format
inline constexpr size_t kPacketBytes = 1206;  // Format
inline constexpr uint16_t kUpper = 0xEEFF;    // Format
inline constexpr uint16_t kLower = 0xDDFF;    // Format: HDL-64E, VLS-128.
inline constexpr uint16_t kThird = 0xCCFF;    // Format: VLS-128 alone, and the next.
inline constexpr uint16_t kFourth = 0xBBFF;   // Format
inline constexpr uint8_t kDualReturn = 0x39;  // Format

enum class Product : uint8_t {
  kHdl32 = 0x21,
  kVlp16 = 0x22,
  kPuckHiRes = 0x24,
  kVlp32 = 0x28,
  kVls128 = 0xA1,
};

// A view of a packet of kPacketBytes.
class Packet {
 public:
  explicit Packet(absl::string_view bytes) : bytes_(bytes.data()) {}

  uint16_t flag(int block) const { return Load<uint16_t>(block * kBlockBytes); }
  // The 32 lasers that a block is of, as its flag says: from 0 to 3; empty for another flag.
  std::optional<int> bank(int block) const;
  // Blocks that are sent: with both returns, a VLS-128 leaves the last four empty.
  int blocks() const;
  // Hundredths of a degree, as sent: may be 36000 and more in a packet that lies.
  int azimuth(int block) const { return Load<uint16_t>(block * kBlockBytes + 2); }
  // In units of the model; 0: no return.
  uint16_t range(int block, int laser) const { return Load<uint16_t>(At(block, laser)); }
  uint8_t reflectivity(int block, int laser) const { return Load<uint8_t>(At(block, laser) + 2); }
  uint32_t microseconds() const { return Load<uint32_t>(1200); }  // Past the hour.
  uint8_t return_mode() const { return Load<uint8_t>(1204); }
  uint8_t product() const { return Load<uint8_t>(1205); }

 private:
  static int At(int block, int laser) { return block * kBlockBytes + 4 + laser * 3; }
  template <typename T>
  T Load(int at) const {
    return codec::LoadAs<T>(bytes_ + at);
  }

  const char* bytes_;
};

// InvalidArgument, saying why, for what is no packet.
absl::Status CheckPacket(absl::string_view bytes);

// True if an HDL-64E sent both returns, which it does not say: then four blocks share an azimuth.
bool Hdl64IsDual(const Packet& packet);

}  // namespace isthmus::readers::velodyne
