#include "client/readers/packets/live/udp_socket.h"

#include <absl/strings/str_cat.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "client/readers/packets/limits.h"
#include "core/io/file_io.h"
#include "core/nanoseconds.h"

namespace isthmus::readers::live {
namespace {

constexpr size_t kDatagramBytes = 65536;  // Format

// An IPv4 sender has an address in IPv6, too, where a socket takes both.
capture::IpAddress SenderOf(const sockaddr_storage& from) {
  capture::IpAddress address;
  if (from.ss_family == AF_INET) {
    sockaddr_in v4;
    std::memcpy(&v4, &from, sizeof(v4));
    std::memcpy(address.bytes.data(), &v4.sin_addr, 4);
    return address;
  }
  sockaddr_in6 v6;
  std::memcpy(&v6, &from, sizeof(v6));
  const auto* bytes = reinterpret_cast<const uint8_t*>(&v6.sin6_addr);
  address.v6 = !IN6_IS_ADDR_V4MAPPED(&v6.sin6_addr);
  std::memcpy(address.bytes.data(), address.v6 ? bytes : bytes + 12, address.v6 ? 16 : 4);
  return address;
}

absl::Status SocketError(absl::string_view action, int error) {
  return absl::UnavailableError(absl::StrCat("cannot ", action, ": ", io::Explain(error)));
}

bool SetOption(int socket, int level, int option, int value) {
  return setsockopt(socket, level, option, &value, sizeof(value)) == 0;
}

bool JoinGroup(int socket, const UdpUri& uri) {
  if (uri.address.ss_family == AF_INET) {
    sockaddr_in v4;
    std::memcpy(&v4, &uri.address, sizeof(v4));
    ip_mreq request = {};
    request.imr_multiaddr = v4.sin_addr;
    return setsockopt(socket, IPPROTO_IP, IP_ADD_MEMBERSHIP, &request, sizeof(request)) == 0;
  }
  sockaddr_in6 v6;
  std::memcpy(&v6, &uri.address, sizeof(v6));
  ipv6_mreq request = {};
  request.ipv6mr_multiaddr = v6.sin6_addr;
  request.ipv6mr_interface = v6.sin6_scope_id;
  return setsockopt(socket, IPPROTO_IPV6, IPV6_JOIN_GROUP, &request, sizeof(request)) == 0;
}

int64_t SystemNow() {
  timespec now = {};
  clock_gettime(CLOCK_REALTIME, &now);
  return now.tv_sec * kNsPerSecond + now.tv_nsec;
}

}  // namespace

UdpSocket::~UdpSocket() {
  if (socket_ >= 0) close(socket_);
  if (wake_ >= 0) close(wake_);
}

absl::StatusOr<std::unique_ptr<UdpSocket>> UdpSocket::Open(const UdpUri& uri) {
  std::unique_ptr<UdpSocket> result(new UdpSocket());
  absl::Status status = result->Start(uri);
  // A host may have no IPv6.
  if (!status.ok() && uri.any) {
    absl::StatusOr<UdpUri> v4 = ParseUdpUri(absl::StrCat("udp://0.0.0.0:", uri.port));
    if (!v4.ok()) return v4.status();
    result.reset(new UdpSocket());
    status = result->Start(*v4);
  }
  if (!status.ok()) return status;
  return result;
}

absl::Status UdpSocket::Start(const UdpUri& uri) {
  bytes_.resize(kDatagramBytes);
  wake_ = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
  if (wake_ < 0) return SocketError("make an event for the socket", errno);
  socket_ = socket(uri.address.ss_family, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (socket_ < 0) return SocketError("make a socket", errno);
  if (uri.any) SetOption(socket_, IPPROTO_IPV6, IPV6_V6ONLY, 0);
  // Other programs may listen to the same group.
  if (uri.multicast) SetOption(socket_, SOL_SOCKET, SO_REUSEADDR, 1);
  Enlarge();
  SetOption(socket_, SOL_SOCKET, SO_RXQ_OVFL, 1);
  SetOption(socket_, SOL_SOCKET, SO_TIMESTAMPNS, 1);
  if (bind(socket_, reinterpret_cast<const sockaddr*>(&uri.address), uri.size) != 0) {
    const int error = errno;
    if (error == EADDRINUSE) {
      return absl::UnavailableError(
          absl::StrCat("port ", uri.port, " is in use: another program reads the sensor; stop it"));
    }
    if (error == EADDRNOTAVAIL) {
      return absl::InvalidArgumentError(
          "the address does not belong to this computer: give the address of the interface to "
          "which the sensor sends, or no address");
    }
    return SocketError(absl::StrCat("listen to port ", uri.port), error);
  }
  if (uri.multicast && !JoinGroup(socket_, uri)) {
    return SocketError("join the multicast group", errno);
  }
  return absl::OkStatus();
}

void UdpSocket::Enlarge() {
  // Beyond net.core.rmem_max only with CAP_NET_ADMIN.
  if (!SetOption(socket_, SOL_SOCKET, SO_RCVBUFFORCE, kReceiveBufferBytes)) {
    SetOption(socket_, SOL_SOCKET, SO_RCVBUF, kReceiveBufferBytes);
  }
  socklen_t size = sizeof(buffer_bytes_);
  getsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &buffer_bytes_, &size);
}

absl::StatusOr<std::optional<UdpSocket::Arrived>> UdpSocket::Receive() {
  while (true) {
    pollfd waits[] = {{wake_, POLLIN, 0}, {socket_, POLLIN, 0}};
    if (poll(waits, 2, -1) < 0) {
      if (errno == EINTR) continue;
      return SocketError("wait for packets", errno);
    }
    if (waits[0].revents != 0) return std::nullopt;
    std::optional<Arrived> arrived = Fetch();
    if (arrived) return arrived;
    // A datagram with a bad checksum is gone when it is fetched; or a reply of the network came.
    if (errno != EAGAIN && errno != EINTR && errno != ECONNREFUSED) {
      return SocketError("receive packets", errno);
    }
  }
}

std::optional<UdpSocket::Arrived> UdpSocket::Fetch() {
  sockaddr_storage from = {};
  iovec vector = {bytes_.data(), bytes_.size()};
  alignas(cmsghdr) char control[256];
  msghdr message = {};
  message.msg_name = &from;
  message.msg_namelen = sizeof(from);
  message.msg_iov = &vector;
  message.msg_iovlen = 1;
  message.msg_control = control;
  message.msg_controllen = sizeof(control);
  const ssize_t size = recvmsg(socket_, &message, 0);
  if (size < 0) return std::nullopt;
  Arrived arrived;
  arrived.payload = absl::string_view(bytes_.data(), static_cast<size_t>(size));
  arrived.source = SenderOf(from);
  for (cmsghdr* part = CMSG_FIRSTHDR(&message); part != nullptr;
       part = CMSG_NXTHDR(&message, part)) {
    if (part->cmsg_level != SOL_SOCKET) continue;
    if (part->cmsg_type == SO_RXQ_OVFL) {
      uint32_t dropped = 0;
      std::memcpy(&dropped, CMSG_DATA(part), sizeof(dropped));
      dropped_ += dropped - last_dropped_;  // Right also where the kernel's count starts again.
      last_dropped_ = dropped;
    } else if (part->cmsg_type == SCM_TIMESTAMPNS) {
      timespec time = {};
      std::memcpy(&time, CMSG_DATA(part), sizeof(time));
      arrived.arrival_ns = time.tv_sec * kNsPerSecond + time.tv_nsec;
    }
  }
  if (arrived.arrival_ns == 0) arrived.arrival_ns = SystemNow();
  return arrived;
}

void UdpSocket::Interrupt() {
  const uint64_t one = 1;
  // Full only after 2^64 of them, and then it wakes anyway.
  (void)!write(wake_, &one, sizeof(one));
}

}  // namespace isthmus::readers::live
