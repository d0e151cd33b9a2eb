// Disjoint sets of 0 .. n-1 (Tarjan 1975): union by size, paths halved.
#pragma once

#include <cstddef>
#include <numeric>
#include <utility>
#include <vector>

namespace isthmus {

// Not thread safe, reads included: Find shortens paths.
class UnionFind {
 public:
  explicit UnionFind(size_t n) : parent_(n), size_(n, 1) {
    std::iota(parent_.begin(), parent_.end(), size_t{0});
  }

  // The representative of the set that holds i.
  size_t Find(size_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }

  // False, and nothing changes, when both are in one set already.
  bool Unite(size_t i, size_t j) {
    i = Find(i);
    j = Find(j);
    if (i == j) return false;
    if (size_[i] < size_[j]) std::swap(i, j);
    parent_[j] = i;
    size_[i] += size_[j];
    return true;
  }

 private:
  std::vector<size_t> parent_, size_;
};

}  // namespace isthmus
