#include "floam/match_quality.h"

#include <algorithm>

namespace isthmus::floam {
namespace {

constexpr double kFading = 0.05;
constexpr double kTypicalAgreement = 0.95, kTypicalShare = 0.75;  // Of the averages.

double Share(const MatchResult& match) {
  return static_cast<double>(match.used) / std::max(match.features, 1);
}

}  // namespace

void MatchQuality::Add(const MatchResult& match) {
  const double weight = agreement_ > 0 ? kFading : 1;
  agreement_ += weight * (match.agreement - agreement_);
  share_ += weight * (Share(match) - share_);
}

bool MatchQuality::IsTypical(const MatchResult& match) const {
  // Where a direction is not observed, a wrong place fits as well as the right one.
  return !match.degeneracy.any() && match.agreement >= kTypicalAgreement * agreement_ &&
         Share(match) >= kTypicalShare * share_;
}

}  // namespace isthmus::floam
