// How well scans matched lately.
#pragma once

#include "floam/scan_matcher.h"

namespace isthmus::floam {

// Tells a place found again from one that only looks like it.
class MatchQuality {
 public:
  // Of a scan that was tracked without interruption.
  void Add(const MatchResult& match);
  // Whether a match after an interruption is about as good.
  bool IsTypical(const MatchResult& match) const;

 private:
  double agreement_ = 0, share_ = 0;  // Fading averages; zero before the first Add.
};

}  // namespace isthmus::floam
