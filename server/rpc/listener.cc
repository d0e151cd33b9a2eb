#include "server/rpc/listener.h"

#include <absl/strings/str_cat.h>
#include <fcntl.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

#include "core/concurrency/thread_role.h"

namespace isthmus::rpc {
namespace {

// Longer than any client needs for its first bytes, and what gRPC gives a handshake.
constexpr int kPatienceS = 10;
// Connections that the system holds ready: a second of what a network brings after it was away.
constexpr int kBacklog = 1024;
// Connections taken before others listen: none waits for long.
constexpr int kAtOnce = 64;
// Until it is tried again where even the spare file does not help.
constexpr int kOutOfFilesMs = 100;

using Addresses = std::unique_ptr<addrinfo, decltype(&freeaddrinfo)>;

void SetOption(int file, int level, int name, int value) {
  // One that the system has not makes connections slower at worst.
  (void)setsockopt(file, level, name, &value, sizeof(value));
}

// "host", "port" of "host:port" and "[host]:port".
std::pair<std::string, std::string> Split(const std::string& listen) {
  const size_t colon = listen.rfind(':');
  std::string host = listen.substr(0, colon);
  if (host.size() > 1 && host.front() == '[' && host.back() == ']') {
    host = host.substr(1, host.size() - 2);
  }
  return {host, listen.substr(colon + 1)};
}

absl::StatusOr<Addresses> Resolve(const std::string& host, const std::string& port) {
  addrinfo hints = {};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_PASSIVE | AI_NUMERICSERV;
  addrinfo* found = nullptr;
  const int error = getaddrinfo(host.c_str(), port.c_str(), &hints, &found);
  if (error == 0) return Addresses(found, freeaddrinfo);
  return absl::UnavailableError(absl::StrCat("cannot listen at ", host, ": ", gai_strerror(error),
                                             "; name an address of this machine"));
}

void SetPort(sockaddr* address, uint16_t port) {
  const bool is_v6 = address->sa_family == AF_INET6;
  (is_v6 ? reinterpret_cast<sockaddr_in6*>(address)->sin6_port
         : reinterpret_cast<sockaddr_in*>(address)->sin_port) = htons(port);
}

uint16_t PortOf(int file) {
  sockaddr_storage address = {};
  socklen_t size = sizeof(address);
  if (getsockname(file, reinterpret_cast<sockaddr*>(&address), &size) != 0) return 0;
  return ntohs(address.ss_family == AF_INET6
                   ? reinterpret_cast<const sockaddr_in6&>(address).sin6_port
                   : reinterpret_cast<const sockaddr_in&>(address).sin_port);
}

// Not open, with errno, where it cannot.
io::File ListenAt(const addrinfo& at) {
  const int type = SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC;
  io::File file(socket(at.ai_family, type, 0), "socket", io::DiskCalls::System());
  if (!file.is_open()) return file;
  const int number = file.descriptor();
  SetOption(number, SOL_SOCKET, SO_REUSEADDR, 1);  // After a restart, while old connections end.
  SetOption(number, IPPROTO_TCP, TCP_NODELAY, 1);  // Accepted sockets inherit these.
  SetOption(number, IPPROTO_TCP, TCP_DEFER_ACCEPT, kPatienceS);
  if (at.ai_family == AF_INET6) {
    const auto& v6 = *reinterpret_cast<const sockaddr_in6*>(at.ai_addr);
    const bool all = IN6_IS_ADDR_UNSPECIFIED(&v6.sin6_addr);
    SetOption(number, IPPROTO_IPV6, IPV6_V6ONLY, all ? 0 : 1);
  }
  const bool listens =
      bind(number, at.ai_addr, at.ai_addrlen) == 0 && listen(number, kBacklog) == 0;
  const int error = errno;
  if (!listens) file = io::File();
  errno = error;
  return file;
}

// Every address of the machine is asked for as "0.0.0.0" or "[::]": both mean both.
absl::StatusOr<std::vector<io::File>> ListenAtAll(const std::string& listen) {
  auto [host, port_text] = Split(listen);
  const bool all = host == "0.0.0.0" || host == "::";
  std::vector<io::File> sockets;
  int error = 0;
  uint16_t port = 0;
  for (const char* name : {all ? "::" : host.c_str(), all ? "0.0.0.0" : ""}) {
    if (*name == '\0' || (all && !sockets.empty())) break;
    const absl::StatusOr<Addresses> addresses = Resolve(name, port_text);
    if (!addresses.ok() && !all) return addresses.status();
    if (!addresses.ok()) continue;
    for (const addrinfo* at = addresses->get(); at != nullptr; at = at->ai_next) {
      if (port != 0) SetPort(at->ai_addr, port);
      io::File file = ListenAt(*at);
      if (!file.is_open()) error = errno;
      if (!file.is_open() && error == EADDRINUSE) break;
      if (!file.is_open()) continue;
      port = PortOf(file.descriptor());
      sockets.push_back(std::move(file));
    }
  }
  if (!sockets.empty() && error != EADDRINUSE) return sockets;
  return absl::UnavailableError(
      absl::StrCat("cannot listen at ", listen,
                   ": the address is in use, or not one of this machine; name another one"));
}

bool WasClosed(int socket) {
  char first = 0;
  return recv(socket, &first, 1, MSG_PEEK | MSG_DONTWAIT) == 0;
}

io::File Spare() {
  return {open("/dev/null", O_RDONLY | O_CLOEXEC), "/dev/null", io::DiskCalls::System()};
}

}  // namespace

absl::StatusOr<std::unique_ptr<Listener>> Listener::Open(const std::string& listen) {
  absl::StatusOr<std::vector<io::File>> sockets = ListenAtAll(listen);
  if (!sockets.ok()) return sockets.status();
  const int port = PortOf(sockets->front().descriptor());
  return std::unique_ptr<Listener>(new Listener(*std::move(sockets), port));
}

Listener::Listener(std::vector<io::File> sockets, int port)
    : sockets_(std::move(sockets)),
      port_(port),
      wake_(eventfd(0, EFD_CLOEXEC), "eventfd", io::DiskCalls::System()),
      spare_(Spare()) {}

Listener::~Listener() { Stop(); }

void Listener::Start(int max_files, Take take) {
  max_files_ = max_files;
  take_ = std::move(take);
  thread_ = std::thread([this] { Run(); });
}

void Listener::Stop() {
  if (!thread_.joinable()) return;
  (void)eventfd_write(wake_.descriptor(), 1);
  thread_.join();
}

void Listener::Run() {
  NameThread("accept");
  std::vector<pollfd> waiting;
  for (const io::File& socket : sockets_) waiting.push_back({socket.descriptor(), POLLIN, 0});
  waiting.push_back({wake_.descriptor(), POLLIN, 0});
  while (true) {
    (void)poll(waiting.data(), waiting.size(), -1);
    if (waiting.back().revents != 0) return;
    for (const pollfd& ready : waiting) {
      if (ready.revents != 0) AcceptAll(ready.fd);
    }
  }
}

void Listener::AcceptAll(int listening) {
  for (int i = 0; i < kAtOnce; ++i) {
    const int socket = accept4(listening, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (socket < 0) {
      if (errno == EMFILE || errno == ENFILE) RefuseOne(listening);
      // Else none waits, or one that gave up while it did.
      return;
    }
    // The system gives out the lowest number that is free: so many files at least are open.
    if (socket >= max_files_ || WasClosed(socket)) {
      refused_ += socket >= max_files_ ? 1 : 0;
      close(socket);
      continue;
    }
    take_(listening, socket);
  }
}

void Listener::RefuseOne(int listening) {
  spare_ = io::File();
  const int socket = accept4(listening, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
  if (socket >= 0) {
    ++refused_;
    close(socket);
  }
  spare_ = Spare();
  pollfd wake = {wake_.descriptor(), POLLIN, 0};
  if (!spare_.is_open()) (void)poll(&wake, 1, kOutOfFilesMs);
}

}  // namespace isthmus::rpc
