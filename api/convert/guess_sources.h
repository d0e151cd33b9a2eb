// The sources of transforms' guesses, in words of ours and of the API.
#pragma once

#include <utility>

#include "core/map/match.h"
#include "isthmus/v1/map_service.pb.h"

namespace isthmus::convert {

inline constexpr std::pair<GuessSource, v1::GuessSource> kGuessSources[] = {
    {GuessSource::kNone, v1::GUESS_SOURCE_UNSPECIFIED},
    {GuessSource::kOdometry, v1::GUESS_SOURCE_ODOMETRY},
    {GuessSource::kPlaces, v1::GUESS_SOURCE_PLACES},
    {GuessSource::kBirdsEye, v1::GUESS_SOURCE_BIRDS_EYE},
    {GuessSource::kStructure, v1::GUESS_SOURCE_STRUCTURE},
    {GuessSource::kRepeats, v1::GUESS_SOURCE_REPEATS},
    {GuessSource::kAnchors, v1::GUESS_SOURCE_ANCHORS},
    {GuessSource::kPaper, v1::GUESS_SOURCE_PAPER},
    {GuessSource::kByHand, v1::GUESS_SOURCE_BY_HAND},
};

}  // namespace isthmus::convert
