#include "server/matching/paper/correspondence.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace isthmus::matching {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

// A descriptor told apart by one number above zero.
FpfhDescriptor At(float value) { return FpfhDescriptor::Constant(value); }

CorrespondenceOptions Nearest(int k) {
  CorrespondenceOptions options;
  options.nearest = k;
  return options;
}

TEST(MatchReciprocally, OnlyMutualNearestMatch) {
  // 2.0 is nearest to 2.1, but 2.1 prefers 2.11.
  const auto matches =
      MatchReciprocally({At(1), At(2), At(2.11f)}, {At(1.1f), At(2.1f)}, Nearest(1));
  EXPECT_THAT(matches, ElementsAre(FeatureMatch{0, 0}, FeatureMatch{2, 1}));
}

TEST(MatchReciprocally, MorePartnersWithLargerK) {
  const auto matches =
      MatchReciprocally({At(1), At(2), At(2.11f)}, {At(1.1f), At(2.1f)}, Nearest(2));
  EXPECT_THAT(matches, ElementsAre(FeatureMatch{0, 0}, FeatureMatch{1, 0}, FeatureMatch{1, 1},
                                   FeatureMatch{2, 1}));
}

TEST(MatchReciprocally, TiesGoToTheLowerIndex) {
  const auto matches = MatchReciprocally({At(1)}, {At(2), At(2)}, Nearest(1));
  EXPECT_THAT(matches, ElementsAre(FeatureMatch{0, 0}));
}

TEST(MatchReciprocally, EmptyDescriptorsMatchNothing) {
  EXPECT_THAT(MatchReciprocally({At(0), At(1)}, {At(0)}, Nearest(3)), IsEmpty());
  EXPECT_THAT(MatchReciprocally({}, {At(1)}, Nearest(3)), IsEmpty());
  EXPECT_THAT(MatchReciprocally({At(1)}, {}, Nearest(3)), IsEmpty());
  EXPECT_THAT(MatchReciprocally({At(1)}, {At(1)}, Nearest(0)), IsEmpty());
}

}  // namespace
}  // namespace isthmus::matching
