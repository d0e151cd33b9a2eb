// Outlines with fewer corners.
#pragma once

#include <vector>

#include "core/floors/outline.h"

namespace isthmus::floors {

// Leaves out corners within a cell and a half of what remains; fewer of them where outlines would
// cross themselves or each other.
void Simplify(std::vector<Outline>* outlines);

// True if sides of the outlines meet elsewhere than at the corners of neighbours.
bool Cross(const std::vector<Outline>& outlines);

}  // namespace isthmus::floors
