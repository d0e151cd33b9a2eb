// Retirement of submaps that were seen again so often that they add nothing, which keeps a map that
// is driven over for days from growing.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "core/ids.h"
#include "core/map/composed_map.h"
#include "server/matching/prepared/prepared_submap.h"

namespace isthmus::matching {

struct RevisitOptions {
  bool retire = true;
  // A submap goes when this share of its surface ...
  double min_share = 0.9;
  // ... was looked at by so many newer submaps each: seen again, or looked through because it is
  // gone. At most 255.
  int min_looks = 30;
  // The newest of every session stay: its robot goes on from them.
  int keep_newest = 8;
  // For so long it stays after the last of those looks by another session: whoever deletes one that
  // should not have been has what it looked at back.
  double grace_h = 24;
};

// Fetches a prepared submap; null where its points cannot be read.
using PreparedReader = std::function<std::shared_ptr<const PreparedSubmap>(const SubmapId& submap)>;

// When a session was finished, in the time of now_ns below; 0 while it is active.
using FinishReader = std::function<int64_t(const SessionId& session)>;

// Not thread safe; starts no threads. Keeps counts, so that what a new submap costs does not grow
// with the map: each looks at the nearest older ones only, and each call takes in a few, those that
// end first before others. What is left over comes with the next calls.
class RevisitCounter {
 public:
  RevisitCounter(const RevisitOptions& options, PreparedReader prepared);
  ~RevisitCounter();

  // `placed` is the whole map. Submaps that cannot be read neither go nor let others go. Newer is
  // what ends later (last_stamp_ns); a submap that contradicts more of the older one than it
  // confirms is not counted, because then one of the two lies in the wrong place. Of looks by
  // another robot than the submap's own, those without a third robot's between them count once: a
  // robot alone, however often it drives, does not make another's map go. Looks of a session that
  // is gone are taken back. Returns those that may go, in order of id: nothing until it is worth a
  // new map (4 submaps, or 5 % of their session), and then at most a few of a place at a time, so
  // that those left are counted before more go. What was returned should not be in the next call;
  // what is not in a call is forgotten. Deterministic for the same sequence of calls. The
  // grace counts from when a look is taken in, `now_ns`, since any fixed moment, or from when its
  // session was finished: counted anew, as after each start, what looked long ago does not begin it
  // again.
  std::vector<SubmapId> Update(const std::vector<PlacedSubmap>& placed, int64_t now_ns,
                               const FinishReader& finished_ns);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace isthmus::matching
