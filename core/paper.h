// The parts of this build that are there to compare with the paper: its matching chain and A-LOAM.
#pragma once

namespace isthmus {

// The CMake option ISTHMUS_PAPER.
#ifdef ISTHMUS_WITHOUT_PAPER
inline constexpr bool kHasPaper = false;
#else
inline constexpr bool kHasPaper = true;
#endif

}  // namespace isthmus
