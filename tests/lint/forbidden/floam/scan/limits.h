inline constexpr double kNoReason = 1;
// Metres. A guess.
inline constexpr double kFarM = 2;
