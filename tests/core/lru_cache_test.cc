#include "core/lru_cache.h"

#include <gtest/gtest.h>

#include <string>

namespace isthmus {
namespace {

using Cache = LruCache<int, std::string>;

std::string DrainOldestFirst(Cache& cache) {
  std::string order;
  for (; !cache.empty(); cache.DropOldest()) order += cache.oldest().value;
  return order;
}

TEST(LruCacheTest, WhatWasUsedLongestAgoComesFirst) {
  Cache cache;
  cache.Put(1, "a");
  cache.Put(2, "b");
  cache.Put(3, "c");
  ASSERT_NE(cache.Use(1), nullptr);
  EXPECT_EQ(*cache.Use(1), "a");
  EXPECT_EQ(cache.Use(4), nullptr);
  EXPECT_EQ(DrainOldestFirst(cache), "bca");
  EXPECT_EQ(cache.Use(1), nullptr);
}

TEST(LruCacheTest, KnowsWhatAllWeigh) {
  Cache cache;
  cache.Put(1, "a", 10);
  cache.Put(2, "b", 5);
  EXPECT_EQ(cache.weight(), 15u);
  cache.Put(1, "A", 3);  // In its place, and the latest.
  EXPECT_EQ(cache.weight(), 8u);
  EXPECT_EQ(cache.size(), 2u);
  cache.Erase(2);
  cache.Erase(2);
  EXPECT_EQ(cache.weight(), 3u);
  EXPECT_EQ(DrainOldestFirst(cache), "A");
  EXPECT_EQ(cache.weight(), 0u);
}

TEST(LruCacheTest, ErasesByKeyAndKeepsTheOrderOfTheRest) {
  Cache cache;
  for (int i = 0; i < 6; ++i) cache.Put(i, std::string(1, static_cast<char>('a' + i)), 1);
  cache.EraseIf([](int key) { return key % 2 == 0; });
  EXPECT_EQ(cache.weight(), 3u);
  EXPECT_EQ(DrainOldestFirst(cache), "bdf");
}

}  // namespace
}  // namespace isthmus
