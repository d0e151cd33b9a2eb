// OctoMap's sensor model, as its OcTree has it where nothing else is said.
#pragma once

namespace isthmus::composition {

// Log-odds ln(p / (1 - p)), rounded to float, of
inline constexpr float kHitLogOdds = 0.847297847F;    // Math: a hit, p = 0.7;
inline constexpr float kMissLogOdds = -0.405465096F;  // Math: a miss, 0.4;
inline constexpr float kLeastLogOdds = -2.00002789F;  // Math: what all is clamped to, 0.1192 ...
inline constexpr float kMostLogOdds = 3.51103067F;    // Math: and 0.971;
inline constexpr float kOccupiedLogOdds = 0;          // Math: what is there from here on, 0.5.

}  // namespace isthmus::composition
