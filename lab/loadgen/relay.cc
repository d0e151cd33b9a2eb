#include "lab/loadgen/relay.h"

#include <absl/strings/str_cat.h>
#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <limits>
#include <utility>
#include <vector>

#include "core/address.h"
#include "lab/loadgen/dial.h"
#include "lab/loadgen/limits.h"

namespace isthmus::loadgen {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();  // Math: beyond any time.

double RelayNowS() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

void MakeQuick(int socket) {
  const int on = 1;
  setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &on, sizeof(on));
}

}  // namespace

absl::StatusOr<std::unique_ptr<Relay>> Relay::Open(const std::string& server,
                                                   const LinkProfile& profile, uint64_t seed) {
  if (absl::Status status = CheckAddress(server); !status.ok()) return status;
  std::unique_ptr<Relay> relay(new Relay(server, profile, seed));
  if (absl::Status status = relay->Listen(); !status.ok()) return status;
  relay->thread_ = std::thread([raw = relay.get()] { raw->Run(); });
  return relay;
}

Relay::Relay(std::string server, const LinkProfile& profile, uint64_t seed)
    : server_(std::move(server)), profile_(profile), random_(seed) {
  stall_at_s_ = RelayNowS() + Draw(profile.stall_every_s);
  reset_at_s_ = RelayNowS() + Draw(profile.reset_every_s);
}

Relay::~Relay() {
  stopping_ = true;
  if (thread_.joinable()) thread_.join();
  for (Pair& pair : pairs_) Close(pair);
  if (listener_ >= 0) close(listener_);
}

std::string Relay::address() const { return absl::StrCat("127.0.0.1:", port_); }

absl::Status Relay::Listen() {
  listener_ = socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  sockaddr_in address = {};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof(address);
  auto* raw = reinterpret_cast<sockaddr*>(&address);
  if (bind(listener_, raw, size) != 0 || listen(listener_, SOMAXCONN) != 0 ||
      getsockname(listener_, raw, &size) != 0) {
    return absl::ResourceExhaustedError("no port is free for a robot's link");
  }
  port_ = ntohs(address.sin_port);
  return absl::OkStatus();
}

double Relay::Draw(double mean) {
  return mean > 0 ? std::exponential_distribution<double>(1 / mean)(random_) : kNever;
}

void Relay::Close(Pair& pair) {
  HangUp(pair.up.from);
  HangUp(pair.up.to);
}

void Relay::Accept() {
  for (;;) {
    const int robot = accept4(listener_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (robot < 0) return;
    const int server = Dial(server_);
    if (server < 0) {
      HangUp(robot);
      continue;
    }
    MakeQuick(robot);
    MakeQuick(server);
    Pair& pair = pairs_.emplace_back();
    pair.up = {robot, server, profile_.up_bytes_s, &up_};
    pair.down = {server, robot, profile_.down_bytes_s, &down_};
  }
}

bool Relay::Read(Direction& direction, double now_s) {
  std::array<char, 65536> bytes;
  while (!direction.has_ended && direction.waiting_bytes < kMaxRelayed) {
    const ssize_t count = recv(direction.from, bytes.data(), bytes.size(), MSG_DONTWAIT);
    if (count < 0) return errno == EAGAIN || errno == EINTR;
    if (count == 0) {
      direction.has_ended = true;
      break;
    }
    const double takes_s =
        direction.bytes_s > 0 ? static_cast<double>(count) / direction.bytes_s : 0;
    direction.free_s = std::max(direction.free_s, std::max(now_s, stalled_until_s_)) + takes_s;
    const double jitter_s = std::uniform_real_distribution<double>(0, 1)(random_);
    const double due_s = direction.free_s + profile_.delay_s + profile_.jitter_s * jitter_s;
    direction.last_s = std::max(direction.last_s, due_s);
    direction.waiting.push_back(
        {direction.last_s, std::string(bytes.data(), static_cast<size_t>(count))});
    direction.waiting_bytes += static_cast<size_t>(count);
  }
  return true;
}

bool Relay::Write(Direction& direction, double now_s) {
  while (!direction.waiting.empty() && direction.waiting.front().due_s <= now_s &&
         now_s >= stalled_until_s_) {
    std::string& bytes = direction.waiting.front().bytes;
    const ssize_t count =
        send(direction.to, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    if (count < 0) return errno == EAGAIN || errno == EINTR;
    *direction.carried += count;
    direction.waiting_bytes -= static_cast<size_t>(count);
    bytes.erase(0, static_cast<size_t>(count));
    if (!bytes.empty()) return true;
    direction.waiting.pop_front();
  }
  return true;
}

bool Relay::Carry(Direction& direction, double now_s) {
  // gRPC never closes one way only.
  return Read(direction, now_s) && Write(direction, now_s) &&
         !(direction.has_ended && direction.waiting.empty());
}

void Relay::PlanFaults(double now_s) {
  if (now_s >= stall_at_s_) {
    stalled_until_s_ = now_s + Draw(profile_.stall_s);
    stall_at_s_ = stalled_until_s_ + Draw(profile_.stall_every_s);
  }
  if (now_s >= reset_at_s_) {
    if (!pairs_.empty()) ++resets_;
    for (Pair& pair : pairs_) Close(pair);
    pairs_.clear();
    reset_at_s_ = now_s + Draw(profile_.reset_every_s);
  }
}

void Relay::Run() {
  std::vector<pollfd> polled;
  while (!stopping_) {
    const double now_s = RelayNowS();
    PlanFaults(now_s);
    Accept();
    polled.assign(1, {listener_, POLLIN, 0});
    bool is_waiting = false;
    for (auto pair = pairs_.begin(); pair != pairs_.end();) {
      if (!Carry(pair->up, now_s) || !Carry(pair->down, now_s)) {
        Close(*pair);
        pair = pairs_.erase(pair);
        continue;
      }
      for (const Direction* direction : {&pair->up, &pair->down}) {
        is_waiting |= !direction->waiting.empty();
        if (direction->waiting_bytes < kMaxRelayed) polled.push_back({direction->from, POLLIN, 0});
      }
      ++pair;
    }
    constexpr int kIdleMs = 50;  // Until a fault that is due, or the end, is noticed.
    poll(polled.data(), polled.size(), is_waiting ? kRelayTickMs : kIdleMs);
  }
}

}  // namespace isthmus::loadgen
