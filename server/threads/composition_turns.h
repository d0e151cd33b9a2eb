// The order in which new submaps come into the merged map: others come before large ones.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "core/map/composed_map.h"

namespace isthmus::server {

// A composition of all that is new keeps everybody waiting for the largest: a few megabytes of
// points strewn over kilometres take as long as hours of a robot's drive. So it goes in turns. The
// smallest come first; those with which the turn would exceed kTurnPoints wait, and then come one
// by one, who waits longest before others, with what is new and small by then. A turn that has one
// of them gives way to what is new once. Not thread safe.
class CompositionTurns {
 public:
  struct Turn {
    std::vector<PlacedSubmap> placed;
    uint64_t waiting = 0;    // New submaps that are not among them.
    bool has_large = false;  // One that others do not have to wait for.
    bool gives_way = false;  // It may end when something new comes, which goes first then.
  };

  // The submaps to compose next, of all that are placed.
  Turn Next(std::vector<PlacedSubmap> placed);
  // The map of that turn is shown. Before the first, everything comes at once.
  void NoteShown(const Turn& turn);
  // These were in a map before the start, and cost nothing: others may wait for the next turn.
  void NoteKept(std::set<SubmapId> kept) {
    has_shown_ = true;
    shown_ = std::move(kept);
  }
  // The turn ended, as it may; the next one with a large submap does not.
  void NoteGaveWay() { put_off_ = PutOff::kEnded; }

 private:
  // The state of those that wait.
  enum class PutOff { kNot, kEnded, kWaited };

  bool has_shown_ = false;
  std::set<SubmapId> shown_;  // In the last map.
  uint64_t turns_ = 0;
  std::map<SubmapId, uint64_t> waits_since_;  // Turn.
  PutOff put_off_ = PutOff::kNot;
};

}  // namespace isthmus::server
