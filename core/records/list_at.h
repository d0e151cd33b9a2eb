// A list, and the revision of the map that it was read at.
#pragma once

#include <cstdint>
#include <vector>

namespace isthmus {

template <typename T>
struct ListAt : std::vector<T> {
  int64_t revision = 0;
};

}  // namespace isthmus
