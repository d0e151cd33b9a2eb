// The way in for connections: the listening sockets, and what is accepted on them.
//
// gRPC 1.51 would listen by itself, but gives up for good when the process has no file left for a
// connection, has no limit on how many there are, and makes a transport (some 30 kB and as many
// microseconds as a scan takes) even for one that is closed at once.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "core/io/file_io.h"
#include "server/rpc/open_connections.h"

namespace isthmus::rpc {

class Listener {
 public:
  // Takes over an accepted socket, which does not block; `listening` is where it came in. Called
  // from the listener's thread.
  using Take = std::function<void(int listening, int socket)>;

  // Listens where io::ListenAt does. Nothing is accepted before Start. Unavailable, saying what to
  // do, where it cannot.
  static absl::StatusOr<std::unique_ptr<Listener>> Open(const std::string& listen);
  ~Listener();  // Stops.

  int port() const { return port_; }

  struct Limits {
    size_t connections;  // Taken over and still open, see OpenConnections.
    int files;           // The process's, about, so that some stay for everything else.
  };

  // One that was closed before its turn costs no more than to be accepted. Beyond the limits, and
  // with no file left, further ones are closed at once.
  void Start(const Limits& limits, Take take);
  // No connection is taken after it, and further ones are refused by the system.
  void Stop();

  uint64_t refused() const { return refused_; }

 private:
  Listener(std::vector<io::File> sockets, int port);

  void Run();
  void AcceptAll(int listening);
  bool HasRoomFor(int socket);
  void RefuseOne(int listening);

  std::vector<io::File> sockets_;
  const int port_;
  io::File wake_;   // Says that it is to stop.
  io::File spare_;  // Given up for a moment where there is no other file.
  int max_files_ = 0;
  OpenConnections open_{0};
  Take take_;
  std::atomic<uint64_t> refused_ = 0;
  std::thread thread_;
};

}  // namespace isthmus::rpc
