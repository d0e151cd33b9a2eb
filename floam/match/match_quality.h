// The quality of recent matches, by which it is decided whether to believe a new one.
#pragma once

#include "floam/match/scan_matcher.h"
#include "floam/scan/scan_image.h"

namespace isthmus::floam {

// A wrong place fits too, but not as well: in drives through museums and campuses, agreement never
// fell below 0.94 of its fading average and the share of features used never below 0.9, while false
// minima after a robot was kidnapped lay below 0.77 and 0.8. Among trees and pipes ground fits
// anywhere, but of what stands a tenth of the usual does at most, a fifth in one right place of a
// hundred. Of the walls around a robot that is where it takes itself to be, those it looks through
// are a few percent indoors, a third in forests, most in a crowd; a wrong place shows itself by
// more of them than are usual there. Not thread safe.
class MatchQuality {
 public:
  // Adds the match of a scan that was tracked without interruption.
  void Add(const MatchResult& match);
  // True if a match where it was expected is believable.
  bool IsUsual(const MatchResult& match) const;
  // True if it may be right although it is unusual: to be followed for a while, not to be built on.
  bool IsDoubtful(const MatchResult& match) const;
  // True if a match anywhere is about as good as those before it: asked of a place found again.
  bool IsTypical(const MatchResult& match) const;
  // The same where a part of what is seen is new.
  bool IsTypicalAtTheEdge(const MatchResult& match) const;

  // Adds such a scan's view of the walls that were there before.
  void AddWalls(const WallsSeen& walls);
  // True if they speak against a place; never before the usual is known.
  bool IsContradicted(const WallsSeen& walls) const;

  double through() const { return through_; }  // Usual share of the walls looked through.
  // Fading averages; zero before the first Add.
  double agreement() const { return agreement_; }
  double share() const { return share_; }

  // For state_codec.h.
  template <typename Self, typename Io>
  static void Fields(Self& self, Io& io) {
    io(self.agreement_, self.share_, self.standing_, self.through_, self.has_walls_);
  }

 private:
  bool IsAtLeast(const MatchResult& match, double agreement, double share) const;
  bool Stands(const MatchResult& match, double standing) const;

  double agreement_ = 0, share_ = 0, standing_ = 0;
  double through_ = 0.05;  // Indoors.
  bool has_walls_ = false;
};

}  // namespace isthmus::floam
