#include "server/rpc/listener.h"

#include <absl/strings/str_cat.h>
#include <fcntl.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

#include "core/concurrency/thread_role.h"
#include "core/io/listening_socket.h"

namespace isthmus::rpc {
namespace {

// Connections taken before others listen: none waits for long.
constexpr int kAtOnce = 64;
// Until it is tried again where even the spare file does not help.
constexpr int kOutOfFilesMs = 100;

bool WasClosed(int socket) {
  char first = 0;
  return recv(socket, &first, 1, MSG_PEEK | MSG_DONTWAIT) == 0;
}

io::File Spare() {
  return {open("/dev/null", O_RDONLY | O_CLOEXEC), "/dev/null", io::DiskCalls::System()};
}

}  // namespace

absl::StatusOr<std::unique_ptr<Listener>> Listener::Open(const std::string& listen) {
  absl::StatusOr<std::vector<io::File>> sockets = io::ListenAt(listen);
  if (!sockets.ok()) {
    return absl::UnavailableError(
        absl::StrCat("cannot listen at ", listen,
                     ": the address is in use, or not one of this machine; name another one (",
                     sockets.status().message(), ")"));
  }
  const int port = io::PortOf(sockets->front());
  return std::unique_ptr<Listener>(new Listener(*std::move(sockets), port));
}

Listener::Listener(std::vector<io::File> sockets, int port)
    : sockets_(std::move(sockets)),
      port_(port),
      wake_(eventfd(0, EFD_CLOEXEC), "eventfd", io::DiskCalls::System()),
      spare_(Spare()) {}

Listener::~Listener() { Stop(); }

void Listener::Start(const Limits& limits, Take take) {
  max_files_ = limits.files;
  open_ = OpenConnections(limits.connections);
  take_ = std::move(take);
  thread_ = std::thread([this] { Run(); });
}

void Listener::Stop() {
  if (thread_.joinable()) {
    (void)eventfd_write(wake_.descriptor(), 1);
    thread_.join();
  }
  sockets_.clear();
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
    if (WasClosed(socket)) {
      close(socket);
    } else if (HasRoomFor(socket)) {
      take_(listening, socket);
    } else {
      ++refused_;
      close(socket);
    }
  }
}

bool Listener::HasRoomFor(int socket) {
  // The system gives out the lowest number that is free: so many files at least are open.
  return socket < max_files_ && open_.Add(socket);
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
