constexpr int kBits = 8;  // Layout.
constexpr int kMost = 3;
void Twice() {
  constexpr double kFarM = 4;
}
