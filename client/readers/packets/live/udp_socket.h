// A socket that packets of a live sensor arrive at.
#pragma once

#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "client/readers/packets/capture/datagram.h"
#include "client/readers/packets/live/udp_uri.h"

namespace isthmus::readers::live {

// Not thread safe, but for Interrupt.
class UdpSocket {
 public:
  // Bound, and joined where the address is a multicast group. InvalidArgument or Unavailable,
  // saying what to do, where the system refuses.
  static absl::StatusOr<std::unique_ptr<UdpSocket>> Open(const UdpUri& uri);
  ~UdpSocket();
  UdpSocket(const UdpSocket&) = delete;
  UdpSocket& operator=(const UdpSocket&) = delete;

  struct Arrived {
    absl::string_view payload;  // Good until the next call.
    capture::IpAddress source;
    int64_t arrival_ns = 0;  // When the kernel had it.
  };
  // Waits for the next datagram; empty when interrupted, now and ever after. Unavailable where the
  // socket fails.
  absl::StatusOr<std::optional<Arrived>> Receive();

  // Datagrams that the kernel dropped so far, because they were not fetched in time.
  uint64_t dropped() const { return dropped_; }
  // Bytes that the kernel holds, by its own count.
  int buffer_bytes() const { return buffer_bytes_; }

  // Thread safe.
  void Interrupt();

 private:
  UdpSocket() = default;
  absl::Status Start(const UdpUri& uri);
  void Enlarge();
  std::optional<Arrived> Fetch();  // Empty, with errno, for none.

  int socket_ = -1, wake_ = -1;
  int buffer_bytes_ = 0;
  uint32_t last_dropped_ = 0;  // As the kernel counts, which starts again at 2^32.
  uint64_t dropped_ = 0;
  std::vector<char> bytes_;
};

}  // namespace isthmus::readers::live
