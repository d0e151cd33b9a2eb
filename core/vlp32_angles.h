// The elevations of a VLP-32C's lasers, which readers, odometry and the simulator have to agree on.
#pragma once

#include <array>

namespace isthmus {

// Degrees, in order of firing (VLP-32C User Manual, table 9-2).
inline constexpr std::array<double, 32> kVlp32Elevations = {  // Format.
    -25.0,  -1.0,   -1.667, -15.639, -11.31, 0.0,    -0.667, -8.843, -7.254, 0.333,  -0.333,
    -6.148, -5.333, 1.333,  0.667,   -4.0,   -4.667, 1.667,  1.0,    -3.667, -3.333, 3.333,
    2.333,  -2.667, -3.0,   7.0,     4.667,  -2.333, -2.0,   15.0,   10.333, -1.333};

}  // namespace isthmus
