#include "core/map/match.h"

#include <utility>

namespace isthmus {
namespace {

// The first name of a value is the one that is written.
constexpr std::pair<MatchReason, const char*> kReasons[] = {
    {MatchReason::kNone, ""},
    {MatchReason::kOk, "OK"},
    {MatchReason::kByHand, "BY_HAND"},
    {MatchReason::kFreeSpace, "FREE_SPACE"},
    {MatchReason::kPossibleTwin, "POSSIBLE_TWIN"},
    {MatchReason::kPossibleTwin, "ENCLOSED"},
    {MatchReason::kAmbiguous, "AMBIGUOUS"},
    {MatchReason::kCycle, "CYCLE"},
    {MatchReason::kGroup, "GROUP"},
    {MatchReason::kLowOverlap, "LOW_OVERLAP"},
    {MatchReason::kLoose, "LOOSE"},
    {MatchReason::kTooSmall, "TOO_SMALL"},
    {MatchReason::kFewComparisons, "FEW_COMPARISONS"},
    {MatchReason::kDegenerate, "DEGENERATE"},
    {MatchReason::kStrained, "STRAINED"},
    {MatchReason::kNotConverged, "NOT_CONVERGED"},
    {MatchReason::kNoCandidate, "NO_CANDIDATE"},
    {MatchReason::kNoPoses, "NO_POSES"},
    {MatchReason::kUnverified, "UNVERIFIED"},
};

constexpr std::pair<GuessSource, const char*> kSources[] = {
    {GuessSource::kNone, ""},
    {GuessSource::kOdometry, "odometry"},
    {GuessSource::kPlaces, "places"},
    {GuessSource::kBirdsEye, "birds_eye"},
    {GuessSource::kStructure, "structure"},
    {GuessSource::kRepeats, "repeats"},
    {GuessSource::kAnchors, "anchors"},
    {GuessSource::kPaper, "paper"},
    {GuessSource::kByHand, "by_hand"},
};

template <typename Enum, size_t n>
const char* NameIn(const std::pair<Enum, const char*> (&table)[n], Enum wanted) {
  for (const auto& [value, name] : table) {
    if (value == wanted) return name;
  }
  return "";
}

template <typename Enum, size_t n>
Enum ValueIn(const std::pair<Enum, const char*> (&table)[n], std::string_view wanted) {
  for (const auto& [value, name] : table) {
    if (name == wanted) return value;
  }
  return Enum::kNone;
}

}  // namespace

const char* ToString(MatchState state) {
  switch (state) {
    case MatchState::kAccepted:
      return "ACCEPTED";
    case MatchState::kRejected:
      return "REJECTED";
    case MatchState::kAmbiguous:
      return "AMBIGUOUS";
    case MatchState::kNotYet:
      return "NOT_YET";
  }
  return "UNKNOWN";
}

const char* ToString(MatchReason reason) { return NameIn(kReasons, reason); }

MatchReason ParseMatchReason(std::string_view name) { return ValueIn(kReasons, name); }

const char* ToString(GuessSource source) { return NameIn(kSources, source); }

GuessSource ParseGuessSource(std::string_view name) { return ValueIn(kSources, name); }

}  // namespace isthmus
