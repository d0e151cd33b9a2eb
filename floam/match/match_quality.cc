#include "floam/match/match_quality.h"

#include <algorithm>

#include "floam/match/limits.h"

namespace isthmus::floam {
namespace {

double Share(const MatchResult& match) {
  return static_cast<double>(match.used) / std::max(match.features, 1);
}

}  // namespace

void MatchQuality::Add(const MatchResult& match) {
  const double weight = agreement_ > 0 ? kQualityFading : 1;
  agreement_ += weight * (match.agreement - agreement_);
  share_ += weight * (Share(match) - share_);
  standing_ += weight * (match.standing - standing_);
}

void MatchQuality::AddWalls(const WallsSeen& walls) {
  if (walls.count() < kFewWalls) return;
  through_ += (has_walls_ ? kWallsFading : 1) * (walls.through_share() - through_);
  has_walls_ = true;
}

bool MatchQuality::IsContradicted(const WallsSeen& walls) const {
  return has_walls_ && walls.count() >= kFewWalls &&
         walls.through_share() > through_ + kMoreThroughUsual;
}

bool MatchQuality::IsUsual(const MatchResult& match) const {
  return IsAtLeast(match, kUsualAgreement, kUsualShare) && Stands(match, kUsualStanding);
}

bool MatchQuality::IsDoubtful(const MatchResult& match) const {
  return IsAtLeast(match, kDoubtfulAgreement, kLowestShare);
}

bool MatchQuality::IsTypical(const MatchResult& match) const {
  return IsAtLeast(match, kTypicalAgreement, kTypicalShare) && Stands(match, kTypicalStanding);
}

bool MatchQuality::IsTypicalAtTheEdge(const MatchResult& match) const {
  return IsAtLeast(match, kEdgeAgreement, kLowestShare) && Stands(match, kUsualStanding);
}

bool MatchQuality::IsAtLeast(const MatchResult& match, double agreement, double share) const {
  return match.agreement >= agreement * agreement_ && Share(match) >= share * share_;
}

bool MatchQuality::Stands(const MatchResult& match, double standing) const {
  return standing_ * match.standing_tried < kFewStanding || match.standing >= standing * standing_;
}

}  // namespace isthmus::floam
