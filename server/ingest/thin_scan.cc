#include "server/ingest/thin_scan.h"

#include <cstdint>

namespace isthmus::ingest {
namespace {

// The finaliser of SplitMix64 (Steele, Lea, Flood 2014): neighbours get unrelated numbers.
uint64_t Mix(uint64_t x) {
  x = (x + 0x9e3779b97f4a7c15ull);
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
  return x ^ (x >> 31);
}

}  // namespace

void ThinScan(size_t most, Scan* scan) {
  const size_t count = scan->points.size();
  if (count <= most) return;
  const auto threshold =
      static_cast<uint64_t>(static_cast<double>(most) / static_cast<double>(count) * 0x1p32);
  size_t kept = 0;
  for (size_t i = 0; i < count; ++i) {
    if ((Mix(i) >> 32) < threshold) scan->points[kept++] = scan->points[i];
  }
  scan->points.resize(kept);
}

}  // namespace isthmus::ingest
