#include "lab/bench/drive.h"

#include <cmath>

namespace isthmus::bench {
namespace {

constexpr int64_t kStartNs = 1'600'000'000'000'000'000;  // Unix time, as any other.

}  // namespace

Scan MakeScan(const Drive& drive, const Shot& shot, uint64_t sequence) {
  Scan scan = drive.scan_of(shot.turn);
  scan.sequence = sequence;
  scan.end_stamp_ns = shot.end_stamp_ns;
  if (shot.view == View::kBlank) scan.points.clear();
  if (shot.view == View::kHalf) std::erase_if(scan.points, [](const auto& p) { return p.x > 0; });
  return scan;
}

Shots InOrder(int turns, double period_s) {
  Shots shots;
  for (int turn = 0; turn < turns; ++turn) {
    shots.push_back({turn, kStartNs + std::llround(1e9 * period_s * (turn + 1))});
  }
  return shots;
}

void Cover(Shots* shots, int at, int count, View view) {
  for (int i = at; i < at + count; ++i) (*shots)[i].view = view;
}

void Drop(Shots* shots, int at, int count) {
  shots->erase(shots->begin() + at, shots->begin() + at + count);
}

void KeepEvery(Shots* shots, int nth) {
  size_t kept = 0;
  for (size_t i = 0; i < shots->size(); i += static_cast<size_t>(nth))
    (*shots)[kept++] = (*shots)[i];
  shots->resize(kept);
}

void Duplicate(Shots* shots, int at) { shots->insert(shots->begin() + at, (*shots)[at]); }

void Swap(Shots* shots, int at) { std::swap((*shots)[at], (*shots)[at + 1]); }

void StepClock(Shots* shots, int at, double by_s) {
  for (size_t i = at; i < shots->size(); ++i) {
    (*shots)[i].end_stamp_ns += std::llround(1e9 * by_s);
  }
}

void PutElsewhere(Shots* shots, int at, int by_turns) {
  for (size_t i = at; i < shots->size(); ++i) (*shots)[i].turn += by_turns;
}

}  // namespace isthmus::bench
