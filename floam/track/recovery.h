// Recovery: finds a lost robot again in the map around where it was last.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "floam/match/feature_map.h"
#include "floam/match/match_quality.h"
#include "floam/odometry_options.h"
#include "floam/scan/scan_frame.h"
#include "floam/track/tracker.h"

namespace isthmus::floam {

// A place is only believed once a second scan confirms it: it must lie where the first, and the
// motion seen within it, predicted. A place that fits as well elsewhere is ambiguous, and not
// believed. The work per scan is bounded: guesses that do not fit in are looked at with the next
// scans. Not thread safe.
class Recovery {
 public:
  explicit Recovery(const OdometryOptions& options);

  // To be called with every scan while lost, before anything is made of it: whether it is worth
  // matching and to be asked about with Find.
  bool IsDue();

  // To be asked for scans that could not be tracked, in order. `tracked` is what tracking made
  // of it. Returns a match to be believed, or none; then `tracker` goes on from the scan before,
  // which was the first to see the place.
  std::optional<MatchResult> Find(const ScanFrame& frame, const MatchResult& tracked,
                                  const MatchQuality& quality, Tracker* tracker, FeatureMap* map);

  // After a gap in which it may have come anywhere near: the best of all places nearby, or none if
  // that is ambiguous.
  std::optional<MatchResult> LookAround(const ScanFrame& frame, Tracker* tracker, FeatureMap* map);

  // The robot is tracked again, by whatever means.
  void Reset();

  // For state_codec.h.
  template <typename Self, typename Io>
  static void Fields(Self& self, Io& io) {
    io(self.candidate_, self.pending_, self.lost_);
  }

 private:
  std::optional<MatchResult> ConfirmCandidate(const ScanFrame& frame, const MatchQuality& quality,
                                              Tracker* tracker, FeatureMap* map);
  // Matches with a part of the features; the best first.
  std::vector<MatchResult> MatchGuesses(const ScanFrame& frame,
                                        const std::vector<ScanPose>& guesses, int iterations,
                                        Tracker* tracker, FeatureMap* map);
  std::optional<MatchResult> Search(const ScanFrame& frame, Tracker* tracker, FeatureMap* map);
  std::vector<ScanPose> NextGuesses(const ScanFrame& frame, const Tracker& tracker);
  bool IsBelievable(const MatchResult& match, const MatchQuality& quality, const Tracker& tracker,
                    double elapsed_s, const FeatureMap& map) const;

  const MatchOptions matching_;
  std::optional<Sighting> candidate_;  // Seen in the scan before, not yet confirmed.
  std::vector<ScanPose> pending_;      // Guesses that are still to be looked at, the next one last.
  int lost_ = 0;                       // Scans in a row.
};

}  // namespace isthmus::floam
