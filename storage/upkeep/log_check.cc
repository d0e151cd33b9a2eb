#include "storage/upkeep/log_check.h"

#include <absl/strings/str_cat.h>

#include <fstream>
#include <vector>

#include "storage/upkeep/record_checks.h"

namespace isthmus::storage {
namespace {

using Bytes = std::vector<unsigned char>;

constexpr size_t kHeaderSize = 32;
constexpr size_t kFrameHeaderSize = 24;
constexpr uint32_t kLogMagic = 0x377f0682;  // Its last bit: sums are over big-endian words.
constexpr uint32_t kMaxPageSize = 65536;

uint32_t Number(const Bytes& bytes, size_t at) {
  return uint32_t{bytes[at]} << 24 | uint32_t{bytes[at + 1]} << 16 | uint32_t{bytes[at + 2]} << 8 |
         uint32_t{bytes[at + 3]};
}

struct Checksum {
  uint32_t a = 0, b = 0;

  void Add(const Bytes& bytes, size_t begin, size_t end, bool is_big_endian) {
    for (size_t at = begin; at < end; at += 8) {
      a += Word(bytes, at, is_big_endian) + b;
      b += Word(bytes, at + 4, is_big_endian) + a;
    }
  }
  bool Is(const Bytes& bytes, size_t at) const {
    return a == Number(bytes, at) && b == Number(bytes, at + 4);
  }

 private:
  static uint32_t Word(const Bytes& bytes, size_t at, bool is_big_endian) {
    return is_big_endian ? Number(bytes, at) : __builtin_bswap32(Number(bytes, at));
  }
};

bool Read(std::ifstream& file, Bytes& bytes) {
  return bool(
      file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size())));
}

}  // namespace

void CheckLog(const std::string& path, StoreReport& report) {
  std::ifstream file(path, std::ios::binary);
  Bytes header(kHeaderSize);
  if (!file || !Read(file, header)) return;
  const bool is_big_endian = (Number(header, 0) & 1) != 0;
  const uint32_t page_size = Number(header, 8);
  Checksum sum;
  sum.Add(header, 0, 24, is_big_endian);
  if ((Number(header, 0) & ~1u) != kLogMagic || page_size > kMaxPageSize || !sum.Is(header, 24)) {
    return AddDamage("the write-ahead log", "its header is broken: none of it is used", report);
  }
  Bytes frame(kFrameHeaderSize + page_size);
  int64_t number = 0, broken = 0, commits = 0;  // `commits` from the broken frame on.
  bool goes_on = false;                         // Something was written behind one of these.
  while (Read(file, frame)) {
    ++number;
    // Left from before the log was begun anew.
    if (Number(frame, 8) != Number(header, 16) || Number(frame, 12) != Number(header, 20)) {
      if (broken == 0) broken = number;
      continue;
    }
    if (broken == 0) {
      sum.Add(frame, 0, 8, is_big_endian);
      sum.Add(frame, kFrameHeaderSize, frame.size(), is_big_endian);
      if (!sum.Is(frame, 16)) broken = number;
    }
    if (broken == 0) continue;
    goes_on = goes_on || commits > 0;
    if (Number(frame, 4) != 0) ++commits;
  }
  if (!goes_on) return;
  AddDamage("the write-ahead log",
            absl::StrCat("frame ", broken, " of ", number, " is broken; ", commits,
                         " commits from there on are lost"),
            report);
}

}  // namespace isthmus::storage
