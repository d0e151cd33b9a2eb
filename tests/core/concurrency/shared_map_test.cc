#include "core/concurrency/shared_map.h"

#include <gtest/gtest.h>

#include <map>
#include <random>
#include <string>
#include <vector>

namespace isthmus {
namespace {

using Numbers = SharedMap<int, std::string>;

std::map<int, std::string> ContentOf(const Numbers& numbers) {
  std::map<int, std::string> content;
  for (const auto& [key, value] : numbers) content.emplace(key, value);
  return content;
}

TEST(SharedMap, HoldsWhatAStandardMapHolds) {
  std::mt19937 rng(1);
  Numbers shared;
  std::map<int, std::string> standard;
  for (int step = 0; step < 5000; ++step) {
    const int key = static_cast<int>(rng() % 700);
    if (rng() % 3 == 0) {
      EXPECT_EQ(shared.Erase(key), standard.erase(key) == 1);
    } else {
      shared.Set(key, std::to_string(step));
      standard[key] = std::to_string(step);
    }
    ASSERT_EQ(shared.size(), standard.size());
    const auto wanted = standard.lower_bound(key);
    const auto found = shared.lower_bound(key);
    ASSERT_EQ(found == shared.end(), wanted == standard.end());
    if (wanted != standard.end()) {
      ASSERT_EQ(found.key(), wanted->first);
      ASSERT_EQ(*shared.Find(wanted->first), wanted->second);
      ASSERT_EQ(shared.back(), standard.rbegin()->second);
    }
  }
  EXPECT_EQ(ContentOf(shared), standard);
  const auto is_odd = [](int key, const std::string&) { return key % 2 == 1; };
  const size_t gone = std::erase_if(standard, [](const auto& item) { return item.first % 2 == 1; });
  EXPECT_EQ(shared.EraseIf(is_odd), gone);
  EXPECT_EQ(ContentOf(shared), standard);
  EXPECT_EQ(shared.EraseIf([](int, const auto&) { return true; }), standard.size());
  EXPECT_TRUE(shared.empty());
  EXPECT_TRUE(shared.begin() == shared.end());
}

TEST(SharedMap, CopiesDoNotSeeWhatComesLater) {
  Numbers numbers;
  std::vector<Numbers> copies;
  for (int i = 0; i < 300; ++i) {
    copies.push_back(numbers);
    numbers.Set(i, std::to_string(i));
  }
  numbers.Set(7, "seven");
  numbers.Erase(8);
  for (int i = 0; i < 300; ++i) {
    ASSERT_EQ(copies[static_cast<size_t>(i)].size(), static_cast<size_t>(i));
  }
  EXPECT_EQ(*copies[299].Find(7), "7");
  EXPECT_EQ(*copies[299].Find(8), "8");
  EXPECT_EQ(*numbers.Find(7), "seven");
  EXPECT_EQ(numbers.Find(8), nullptr);
}

TEST(SharedMap, ValuesAreSharedAndLiveAsLongAsAnybodyHasThem) {
  Numbers numbers;
  for (int i = 0; i < 1000; ++i) numbers.Set(i, std::to_string(i));
  Numbers copy = numbers;
  copy.Set(500, "new");
  for (int i = 0; i < 1000; ++i) {
    EXPECT_EQ(numbers.Get(i) == copy.Get(i), i != 500);
  }
  const std::weak_ptr<const std::string> old = numbers.Get(500);
  numbers = copy;
  EXPECT_TRUE(old.expired());
}

}  // namespace
}  // namespace isthmus
