// Options of the archive that keeps the scans of robots, so that a map can be rebuilt from it.
#pragma once

#include <cstdint>
#include <string>

namespace isthmus::server {

enum class ArchiveMode {
  kOff,
  kRounded,  // All of a scan, its coordinates rounded.
  kFull,     // The scans bit by bit.
};

struct ArchiveOptions {
  ArchiveMode mode = ArchiveMode::kOff;
  // The map folder; its scans/ holds the archive. Empty: there is none, with any `mode`.
  std::string directory = {};
  // A scan that cannot be kept is not taken, and nothing becomes durable whose scans are not. Else
  // the session goes on without, and its status lists the missing ones.
  bool required = true;
  // For kRounded: the step to which coordinates are rounded, metres.
  double resolution_m = 0.002;
  uint64_t segment_bytes = uint64_t{64} << 20;  // Space is freed in pieces of this size.
};

}  // namespace isthmus::server
