#include "tests/faults/harness/proxy.h"

#include <absl/strings/str_cat.h>
#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <limits>
#include <stdexcept>
#include <vector>

namespace isthmus::faults {
namespace {

constexpr int kTickMs = 4;
constexpr size_t kMaxWaiting = 64 * 1024;
constexpr double kBurstS = 0.05;  // Burst of a limited rate.

double SteadyS() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

int Listen(int& port) {
  const int listener = socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  sockaddr_in address = {};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof(address);
  auto* raw = reinterpret_cast<sockaddr*>(&address);
  if (bind(listener, raw, size) != 0 || listen(listener, 64) != 0 ||
      getsockname(listener, raw, &size) != 0) {
    throw std::runtime_error("the proxy found no port");
  }
  port = ntohs(address.sin_port);
  return listener;
}

int Connect(const std::string& path) {
  sockaddr_un address = {};
  address.sun_family = AF_UNIX;
  path.copy(address.sun_path, sizeof(address.sun_path) - 1);
  const int server = socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (connect(server, reinterpret_cast<sockaddr*>(&address), sizeof(address)) == 0) return server;
  close(server);
  return -1;
}

// Closes so that the other end sees a reset, not an end.
void ResetAndClose(int socket) {
  const linger at_once = {1, 0};
  setsockopt(socket, SOL_SOCKET, SO_LINGER, &at_once, sizeof(at_once));
  close(socket);
}

}  // namespace

Proxy::Proxy(const std::string& backend, uint64_t seed)
    : backend_(backend), listener_(Listen(port_)), random_(seed), last_s_(SteadyS()) {
  thread_ = std::thread([this] { Run(); });
}

Proxy::~Proxy() {
  stopping_ = true;
  thread_.join();
  for (Pair& pair : pairs_) Close(pair, true);
  close(listener_);
}

std::string Proxy::address() const { return absl::StrCat("127.0.0.1:", port_); }

void Proxy::SetRate(double bytes_per_s) {
  MutexLock lock(&mutex_);
  rate_ = bytes_per_s;
  up_ = down_ = 0;
}

void Proxy::Stall(bool is_stalled) {
  MutexLock lock(&mutex_);
  is_stalled_ = is_stalled;
}

void Proxy::Cut(bool is_cut) {
  MutexLock lock(&mutex_);
  is_cut_ = is_cut;
  if (!is_cut) return;
  for (Pair& pair : pairs_) Close(pair, true);
  pairs_.clear();
}

int Proxy::Reset(double probability) {
  MutexLock lock(&mutex_);
  return static_cast<int>(pairs_.remove_if([&](Pair& pair) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    if (pair.is_forgotten || !std::bernoulli_distribution(probability)(random_)) return false;
    Close(pair, true);
    return true;
  }));
}

void Proxy::Forget() {
  MutexLock lock(&mutex_);
  for (Pair& pair : pairs_) {
    if (pair.is_forgotten) continue;
    close(pair.up.to);
    pair.is_forgotten = true;
  }
}

void Proxy::Close(Pair& pair, bool reset) {
  if (reset) ++resets_;
  reset ? ResetAndClose(pair.up.from) : void(close(pair.up.from));
  if (!pair.is_forgotten) close(pair.up.to);
}

void Proxy::Accept() {
  for (;;) {
    const int client = accept4(listener_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (client < 0) return;
    Open(client);
  }
}

void Proxy::Open(int client) {
  const int on = 1;
  setsockopt(client, IPPROTO_TCP, TCP_NODELAY, &on, sizeof(on));
  const int server = is_cut_ ? -1 : Connect(backend_);
  if (server < 0) return ResetAndClose(client);
  pairs_.push_back({{client, server}, {server, client}});
}

bool Proxy::Carry(Direction& direction, double& allowance) {
  if (!direction.has_ended && direction.waiting.size() < kMaxWaiting) {
    char bytes[kMaxWaiting];
    const ssize_t count = read(direction.from, bytes, kMaxWaiting - direction.waiting.size());
    if (count > 0) direction.waiting.append(bytes, static_cast<size_t>(count));
    if (count < 0 && errno != EAGAIN && errno != EINTR) return false;
    direction.has_ended = count == 0;
  }
  const size_t now =
      std::min(direction.waiting.size(), static_cast<size_t>(std::max(0.0, allowance)));
  if (now > 0) {
    const ssize_t count = send(direction.to, direction.waiting.data(), now, MSG_NOSIGNAL);
    if (count < 0 && errno != EAGAIN && errno != EINTR) return false;
    if (count > 0) {
      direction.waiting.erase(0, static_cast<size_t>(count));
      allowance -= static_cast<double>(count);
      bytes_ += count;
    }
  }
  // gRPC never closes one way only.
  return !(direction.has_ended && direction.waiting.empty());
}

void Proxy::Refill() {
  const double now_s = SteadyS();
  if (rate_ > 0) {
    const double more = rate_ * (now_s - last_s_);
    up_ = std::min(up_ + more, rate_ * kBurstS);
    down_ = std::min(down_ + more, rate_ * kBurstS);
  } else {
    up_ = down_ = std::numeric_limits<int32_t>::max();
  }
  last_s_ = now_s;
}

void Proxy::Run() {
  std::vector<pollfd> polled;
  while (!stopping_) {
    polled.assign(1, {listener_, POLLIN, 0});
    {
      MutexLock lock(&mutex_);
      Refill();
      if (!is_stalled_) {
        Accept();
        pairs_.remove_if([this](Pair& pair) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
          if (pair.is_forgotten || (Carry(pair.up, up_) && Carry(pair.down, down_))) return false;
          Close(pair, false);
          return true;
        });
        // Nothing waits for a direction that is held up: the next tick looks again.
        for (const Pair& pair : pairs_) {
          if (pair.is_forgotten) continue;
          if (pair.up.waiting.empty()) polled.push_back({pair.up.from, POLLIN, 0});
          if (pair.down.waiting.empty()) polled.push_back({pair.down.from, POLLIN, 0});
        }
      } else {
        polled.clear();
      }
    }
    poll(polled.data(), polled.size(), kTickMs);
  }
}

}  // namespace isthmus::faults
