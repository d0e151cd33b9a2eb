#include "server/main/listener_watch.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/string_view.h>
#include <absl/strings/strip.h>
#include <netdb.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <cstring>
#include <vector>

namespace isthmus::server {
namespace {

using Deadline = std::chrono::steady_clock::time_point;

// Format. The beginning of a client of HTTP/2 (RFC 9113, section 3.4): the preface, then an empty
// SETTINGS frame. A listener with TLS hangs up on it.
constexpr char kHello[] = "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n\0\0\0\4\0\0\0\0";

struct Endpoint {
  sockaddr_storage address = {};
  socklen_t size = 0;
};

class Socket {
 public:
  explicit Socket(int family)
      : file_(socket(family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)) {}
  ~Socket() {
    if (file_ >= 0) close(file_);
  }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;
  int file() const { return file_; }

 private:
  const int file_;
};

absl::Status ErrnoStatus(const char* what, int error) {
  return absl::UnavailableError(absl::StrCat(what, ": ", std::strerror(error)));
}

std::vector<Endpoint> UnixEndpoint(absl::string_view name, bool is_abstract) {
  Endpoint endpoint;
  auto& address = reinterpret_cast<sockaddr_un&>(endpoint.address);
  address.sun_family = AF_UNIX;
  const size_t skipped = is_abstract ? 1 : 0;
  if (name.size() + skipped >= sizeof(address.sun_path)) return {};
  std::memcpy(address.sun_path + skipped, name.data(), name.size());
  endpoint.size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + skipped + name.size());
  return {endpoint};
}

// The host at which a listener of all addresses is reached from here.
std::string LoopbackOf(const std::string& host) {
  if (host == "0.0.0.0") return "127.0.0.1";
  return host == "::" ? "localhost" : host;
}

std::vector<Endpoint> EndpointsOf(const std::string& address) {
  absl::string_view rest = address;
  if (absl::ConsumePrefix(&rest, "unix-abstract:")) return UnixEndpoint(rest, true);
  if (absl::ConsumePrefix(&rest, "unix:")) {
    absl::ConsumePrefix(&rest, "//");
    return UnixEndpoint(rest, false);
  }
  const size_t colon = address.rfind(':');
  std::string host = address.substr(0, colon);
  if (host.size() > 2 && host.front() == '[') host = host.substr(1, host.size() - 2);
  addrinfo hints = {};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (getaddrinfo(LoopbackOf(host).c_str(), address.substr(colon + 1).c_str(), &hints, &found)) {
    return {};
  }
  std::vector<Endpoint> endpoints;
  for (const addrinfo* one = found; one != nullptr; one = one->ai_next) {
    std::memcpy(&endpoints.emplace_back().address, one->ai_addr, one->ai_addrlen);
    endpoints.back().size = one->ai_addrlen;
  }
  freeaddrinfo(found);
  return endpoints;
}

// True when there is something; false at the deadline.
bool WaitFor(int file, short events, Deadline deadline) {
  for (;;) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(
        deadline - std::chrono::steady_clock::now());
    if (left.count() < 0) return false;
    pollfd wanted = {file, events, 0};
    const int ready = poll(&wanted, 1, static_cast<int>(left.count()) + 1);
    if (ready > 0) return true;
    if (ready < 0 && errno != EINTR) return false;
  }
}

// False if this machine does not have the address now.
bool BindToItsHost(int file, Endpoint endpoint) {
  if (endpoint.address.ss_family == AF_INET) {
    reinterpret_cast<sockaddr_in&>(endpoint.address).sin_port = 0;
  } else if (endpoint.address.ss_family == AF_INET6) {
    reinterpret_cast<sockaddr_in6&>(endpoint.address).sin6_port = 0;
  } else {
    return true;
  }
  return bind(file, reinterpret_cast<const sockaddr*>(&endpoint.address), endpoint.size) == 0 ||
         errno != EADDRNOTAVAIL;
}

absl::Status ProbeEndpoint(const Endpoint& endpoint, Deadline deadline) {
  const Socket socket(endpoint.address.ss_family);
  if (socket.file() < 0) return ErrnoStatus("no connection can be made", errno);
  if (!BindToItsHost(socket.file(), endpoint)) {
    return absl::FailedPreconditionError("this machine does not have the address now");
  }
  const auto* address = reinterpret_cast<const sockaddr*>(&endpoint.address);
  const absl::Status silent =
      absl::DeadlineExceededError("no connection is accepted: the listener does not respond");
  if (connect(socket.file(), address, endpoint.size) != 0) {
    // A socket that is a file says EAGAIN when its backlog is full.
    if (errno == EAGAIN) return silent;
    if (errno != EINPROGRESS) return ErrnoStatus("cannot connect", errno);
    if (!WaitFor(socket.file(), POLLOUT, deadline)) return silent;
    int error = 0;
    socklen_t size = sizeof(error);
    getsockopt(socket.file(), SOL_SOCKET, SO_ERROR, &error, &size);
    if (error != 0) return ErrnoStatus("cannot connect", error);
  }
  // One that hung up already has accepted it.
  if (send(socket.file(), kHello, sizeof(kHello) - 1, MSG_NOSIGNAL) < 0) return absl::OkStatus();
  return WaitFor(socket.file(), POLLIN, deadline) ? absl::OkStatus() : silent;
}

}  // namespace

absl::Status ProbeListener(const std::string& address, std::chrono::milliseconds patience) {
  const Deadline deadline = std::chrono::steady_clock::now() + patience;
  // Without a file no name is resolved either, which says nothing of the address.
  if (const Socket any(AF_UNIX); any.file() < 0) {
    return ErrnoStatus("no connection can be made", errno);
  }
  absl::Status status = absl::FailedPreconditionError(
      absl::StrCat(address, " is not an address of this machine now"));
  for (const Endpoint& endpoint : EndpointsOf(address)) {
    const absl::Status probed = ProbeEndpoint(endpoint, deadline);
    if (probed.ok()) return probed;
    if (!absl::IsFailedPrecondition(probed)) status = probed;
  }
  return status;
}

void ListenerWatch::Probe() {
  const absl::Status status = options_.probe();
  const bool is_away = absl::IsFailedPrecondition(status);
  if (status.ok() || is_away) {
    options_.on_answer();
  } else if (!is_silent_) {
    options_.on_silence(status);
  }
  if (!is_away) is_silent_ = !status.ok();
}

}  // namespace isthmus::server
