#include "floam/match/match_quality.h"

#include <algorithm>

namespace isthmus::floam {
namespace {

constexpr double kAgreementFading = 0.05;
// Initial values of the averages. New surroundings lower the share at once, but hardly the
// agreement.
constexpr double kUsualAgreement = 0.88, kUsualShare = 0.6;
constexpr double kDoubtfulAgreement = 0.7, kDoubtfulShare = 0.4;
constexpr double kTypicalAgreement = 0.94, kTypicalShare = 0.85;
constexpr double kEdgeAgreement = 0.9, kEdgeShare = 0.4;
// Of what stands, where so many are expected that hardly ever so few are met by chance.
constexpr double kUsualStanding = 0.15, kTypicalStanding = 0.4, kFewStanding = 8;

// Fewer tell nothing.
constexpr int kFewWalls = 200;
constexpr double kMoreThrough = 0.2, kWallsFading = 0.2;

double Share(const MatchResult& match) {
  return static_cast<double>(match.used) / std::max(match.features, 1);
}

}  // namespace

void MatchQuality::Add(const MatchResult& match) {
  const double weight = agreement_ > 0 ? kAgreementFading : 1;
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
         walls.through_share() > through_ + kMoreThrough;
}

bool MatchQuality::IsUsual(const MatchResult& match) const {
  return IsAtLeast(match, kUsualAgreement, kUsualShare) && Stands(match, kUsualStanding);
}

bool MatchQuality::IsDoubtful(const MatchResult& match) const {
  return IsAtLeast(match, kDoubtfulAgreement, kDoubtfulShare);
}

bool MatchQuality::IsTypical(const MatchResult& match) const {
  return IsAtLeast(match, kTypicalAgreement, kTypicalShare) && Stands(match, kTypicalStanding);
}

bool MatchQuality::IsTypicalAtTheEdge(const MatchResult& match) const {
  return IsAtLeast(match, kEdgeAgreement, kEdgeShare) && Stands(match, kUsualStanding);
}

bool MatchQuality::IsAtLeast(const MatchResult& match, double agreement, double share) const {
  return match.agreement >= agreement * agreement_ && Share(match) >= share * share_;
}

bool MatchQuality::Stands(const MatchResult& match, double standing) const {
  return standing_ * match.standing_tried < kFewStanding || match.standing >= standing * standing_;
}

}  // namespace isthmus::floam
