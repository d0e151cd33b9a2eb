// Damaged folders: no crash, a report, and the rest is served.
#include "tests/faults/harness/damage.h"

#include <gtest/gtest.h>

#include "tests/faults/harness/test_setup.h"

namespace isthmus::faults {
namespace {

// Each damage on a copy of one folder.
class DamageTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    setup_ = new TestSetup;
    master_ = MakeDamageMaster(setup_->get());
    submaps_ = 0;
    for (const auto& [id, session] : ReadStoredMap(CopyOfMaster())) {
      submaps_ += session.submaps.size();
    }
  }
  static void TearDownTestSuite() {
    delete setup_;
    setup_ = nullptr;
  }

  // Reading it as a store would clear its log.
  static std::string CopyOfMaster() {
    const std::string copy = setup_->Path("copy");
    std::filesystem::remove_all(copy);
    std::filesystem::copy(master_, copy);
    return copy;
  }

  static DamageTrial Try(Damage damage, uint64_t seed) {
    DamageTrial trial = TryDamage(setup_->get(), master_, damage, seed);
    EXPECT_TRUE(trial.broken.empty())
        << ToString(damage) << ", seed " << seed << ": " << trial.broken.front();
    return trial;
  }

  static TestSetup* setup_;
  static std::string master_;
  static uint64_t submaps_;
};

TestSetup* DamageTest::setup_ = nullptr;
std::string DamageTest::master_;
uint64_t DamageTest::submaps_ = 0;

TEST_F(DamageTest, ADamagedSubmapIsNamedAndTheRestIsServed) {
  const DamageTrial trial = Try(Damage::kSubmapBits, 1);
  EXPECT_TRUE(trial.is_up);
  EXPECT_NE(trial.words.find("submap"), std::string::npos) << trial.words;
  EXPECT_GE(trial.submaps + 1, submaps_);
  EXPECT_GT(trial.points, 0u);
}

TEST_F(DamageTest, DamagedPagesAreReportedWhereAnythingIsLost) {
  for (const Damage damage : {Damage::kPageBits, Damage::kTornPage, Damage::kTruncated}) {
    const DamageTrial trial = Try(damage, 2);
    // Bits may hit what nobody uses.
    EXPECT_TRUE(trial.is_reported || trial.submaps == submaps_) << ToString(damage);
  }
}

// Durable scans that the log lost are gone: the rest is whole.
TEST_F(DamageTest, WithoutItsLogWhatIsInTheDatabaseIsServed) {
  for (const Damage damage : {Damage::kLogBits, Damage::kTornLog, Damage::kMissingLog}) {
    const DamageTrial trial = Try(damage, 3);
    EXPECT_TRUE(trial.is_up) << ToString(damage) << ": " << trial.words;
    EXPECT_TRUE(trial.is_reported || damage != Damage::kMissingLog);
  }
}

TEST_F(DamageTest, WhatIsNoMapAnyMoreIsRefused) {
  for (const Damage damage : {Damage::kNoise, Damage::kEmptyDatabase}) {
    const DamageTrial trial = Try(damage, 4);
    EXPECT_FALSE(trial.is_up) << ToString(damage);
    EXPECT_NE(trial.words, "") << ToString(damage);
  }
}

}  // namespace
}  // namespace isthmus::faults
