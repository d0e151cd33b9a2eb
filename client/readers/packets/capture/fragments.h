// IP packets that come in fragments, put together.
#pragma once

#include <absl/strings/string_view.h>

#include <bitset>
#include <cstdint>
#include <list>
#include <optional>
#include <string>

#include "client/readers/packets/capture/datagram.h"

namespace isthmus::readers::capture {

// Holds at most kMaxOpenDatagrams packets of 64 KiB, and gives up the oldest for more. Fragments
// may come in any order, and twice. Not thread safe.
class FragmentJoiner {
 public:
  // The whole packet that this fragment completes, which points into the joiner until the next
  // call; empty while some are missing, and for fragments that lie or were cut in the capture.
  std::optional<IpPacket> Add(const IpPacket& fragment, int64_t arrival_ns);

  // Packets of which fragments are missing so far.
  uint64_t lost() const { return lost_ + open_.size(); }

 private:
  static constexpr size_t kMaxBytes = 65536;  // Format
  struct Open {
    IpPacket packet;
    int64_t arrival_ns = 0;  // The first one that came.
    std::string bytes;
    std::bitset<kMaxBytes / 8> here;  // By 8 bytes.
    size_t pieces = 0;                // Bits that are set in `here`.
    std::optional<size_t> size;       // Known by the last fragment.
  };
  std::list<Open>::iterator Find(const IpPacket& fragment, int64_t arrival_ns);

  std::list<Open> open_;  // The oldest first.
  Open done_;
  uint64_t lost_ = 0;
};

}  // namespace isthmus::readers::capture
