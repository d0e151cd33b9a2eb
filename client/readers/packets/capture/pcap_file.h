// A .pcap or .pcapng file, read datagram by datagram.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <cstdio>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "client/readers/packets/capture/datagram.h"
#include "client/readers/packets/capture/fragments.h"

namespace isthmus::readers::capture {

// Holds one frame and the fragments of FragmentJoiner, whatever the file claims. Not thread safe.
class PcapFile {
 public:
  // NotFound and the like as io::File's for a file that cannot be read; InvalidArgument for one
  // that is no capture, or of a link layer that is not known.
  static absl::StatusOr<std::unique_ptr<PcapFile>> Open(const std::string& path);
  // Opens a stream, which the file takes over; `path` is its name in messages.
  static absl::StatusOr<std::unique_ptr<PcapFile>> Open(FILE* stream, const std::string& path);
  ~PcapFile();
  PcapFile(const PcapFile&) = delete;
  PcapFile& operator=(const PcapFile&) = delete;

  struct Arrived {
    Datagram datagram;  // Good until the next call.
    int64_t arrival_ns = 0;
  };
  // The next UDP datagram; empty at the end, and where damage() ends it. With `headers_only`,
  // fragments are not put together: those with the UDP header are given as they are.
  std::optional<Arrived> Next(bool headers_only = false);

  // The part of the file that could not be read, in words: "damaged behind byte 1234 of 5678, ...".
  // Empty if there is none, complete at the end.
  std::string Damage() const;

 private:
  struct Handle;
  PcapFile(std::unique_ptr<Handle> handle, std::string path);
  std::optional<IpPacket> NextPacket();

  std::unique_ptr<Handle> handle_;
  std::string path_;
  FragmentJoiner joiner_;
  int64_t arrival_ns_ = 0;
  uint64_t frames_ = 0;
  uint64_t cut_ = 0;  // Frames of which the capture kept only a part.
  std::string damage_;
};

}  // namespace isthmus::readers::capture
