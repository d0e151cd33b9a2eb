#include "lab/loadgen/misbehaving_clients.h"

#include <grpcpp/create_channel.h>
#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/support/byte_buffer.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <random>
#include <string_view>

#include "client/library/client.h"
#include "lab/loadgen/dial.h"
#include "lab/loadgen/limits.h"

namespace isthmus::loadgen {
namespace {

using Seconds = std::chrono::duration<double>;

// RFC 9113, 3.4 and 6: a client's first words, an empty SETTINGS frame, and the head of a HEADERS
// frame of 16 KiB on stream 1, whose rest then comes byte by byte.
constexpr std::string_view kGreeting(
    "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n"
    "\x00\x00\x00\x04\x00\x00\x00\x00\x00"
    "\x00\x40\x00\x01\x04\x00\x00\x00\x01",
    42);

// A connection that is held; -1 while there is none.
struct Held {
  int socket = -1;
  bool writes = false;
};

// False when the other end has closed. What the server says is thrown away.
bool IsOpen(int socket) {
  char bytes[4096];
  for (;;) {
    const ssize_t count = recv(socket, bytes, sizeof(bytes), MSG_DONTWAIT);
    if (count == 0) return false;
    if (count < 0) return errno == EAGAIN || errno == EWOULDBLOCK;
  }
}

void Send(int socket, std::string_view bytes) {
  (void)send(socket, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
}

std::string Noise(std::mt19937_64& random) {
  std::string noise(1 + random() % kNoiseBytes, '\0');
  for (char& byte : noise) byte = static_cast<char>(random());
  return noise;
}

// One stream of scans that begins with `message`; what the server ends it with.
grpc::Status StreamOnce(grpc::GenericStub& stub, const std::string& message) {
  grpc::ClientContext context;
  context.set_deadline(
      std::chrono::system_clock::now() +
      std::chrono::duration_cast<std::chrono::system_clock::duration>(Seconds(kNoiseTimeoutS)));
  grpc::CompletionQueue queue;
  const auto wait = [&queue] {
    void* tag = nullptr;
    bool ok = false;
    return queue.Next(&tag, &ok) && ok;
  };
  const auto call = stub.PrepareCall(&context, "/isthmus.v1.SessionService/StreamScans", &queue);
  call->StartCall(nullptr);
  wait();
  const grpc::Slice slice(message);
  call->WriteLast(grpc::ByteBuffer(&slice, 1), grpc::WriteOptions(), nullptr);
  wait();
  grpc::ByteBuffer answer;
  do {
    call->Read(&answer, nullptr);
  } while (wait());
  grpc::Status status;
  call->Finish(&status, nullptr);
  wait();
  return status;
}

}  // namespace

MisbehavingClients::MisbehavingClients(const std::string& server,
                                       const MisbehavingClientOptions& options, uint64_t seed) {
  if (options.half_open + options.slow_writers > 0) {
    threads_.emplace_back([this, server, options] { HoldConnections(server, options); });
  }
  if (options.malformed_per_s > 0) {
    threads_.emplace_back(
        [this, server, per_s = options.malformed_per_s, seed] { SendNoise(server, per_s, seed); });
  }
  for (int i = 0; i < options.slow_readers; ++i) {
    threads_.emplace_back([this, server] { ReadSlowly(server); });
  }
}

MisbehavingClients::~MisbehavingClients() {
  stopping_ = true;
  for (std::thread& thread : threads_) thread.join();
}

MisbehavingClientResult MisbehavingClients::Result() const {
  return {closed_, not_made_, pieces_, cut_off_, malformed_, tolerated_, unanswered_};
}

void MisbehavingClients::HoldConnections(const std::string& server,
                                         const MisbehavingClientOptions& options) {
  std::vector<Held> all(static_cast<size_t>(options.half_open + options.slow_writers));
  for (size_t i = static_cast<size_t>(options.half_open); i < all.size(); ++i) all[i].writes = true;
  while (!stopping_) {
    const auto next = std::chrono::steady_clock::now() + Seconds(kMisbehavingPeriodS);
    for (Held& one : all) {
      if (one.socket >= 0 && !IsOpen(one.socket)) {
        close(one.socket);
        one.socket = -1;
        ++closed_;
      }
      if (one.socket >= 0) {
        if (one.writes) Send(one.socket, std::string_view("\0", 1));
        continue;
      }
      one.socket = Dial(server);
      if (one.socket < 0) {
        ++not_made_;
      } else if (one.writes) {
        Send(one.socket, kGreeting);
      }
    }
    std::this_thread::sleep_until(next);
  }
  for (const Held& one : all) {
    if (one.socket >= 0) HangUp(one.socket);
  }
}

void MisbehavingClients::SendNoise(const std::string& server, double per_s, uint64_t seed) {
  std::mt19937_64 random(seed);
  grpc::GenericStub stub(grpc::CreateChannel(server, grpc::InsecureChannelCredentials()));
  auto next = std::chrono::steady_clock::now();
  while (!stopping_) {
    const grpc::Status status = StreamOnce(stub, Noise(random));
    const bool in_time = status.error_code() != grpc::StatusCode::DEADLINE_EXCEEDED &&
                         status.error_code() != grpc::StatusCode::UNAVAILABLE;
    ++(status.ok() ? tolerated_ : in_time ? malformed_ : unanswered_);
    // Behind, after an answer that took long, the rate is kept from there on.
    next = std::max(next + std::chrono::duration_cast<std::chrono::nanoseconds>(Seconds(1 / per_s)),
                    std::chrono::steady_clock::now());
    std::this_thread::sleep_until(next);
  }
}

void MisbehavingClients::ReadSlowly(const std::string& server) {
  client::ClientOptions options;
  options.address = server;
  options.require_server = false;
  options.backoff.max_attempts = 1;
  const auto client = client::Client::Connect(options);
  if (!client.ok()) return;
  const auto pause = [this] {
    for (int i = 0; i < 10 && !stopping_; ++i) {
      std::this_thread::sleep_for(Seconds(kMisbehavingPeriodS / 10));
    }
    return !stopping_;
  };
  do {
    const absl::Status status = (*client)->QueryRegion({}, [&](const RegionChunk&) {
      ++pieces_;
      return pause();
    });
    if (!status.ok() && !stopping_ && !absl::IsNotFound(status)) ++cut_off_;
  } while (pause());
}

}  // namespace isthmus::loadgen
