// Settings of the odometry. The defaults suit every sensor and scene tried; none is needed to start.
#pragma once

namespace isthmus::floam {

enum class OdometryMode {
  kFloam,       // The paper's two stages of distortion compensation.
  kContinuous,  // Pose and in-scan motion estimated together.
};

struct OdometryOptions {
  OdometryMode mode = OdometryMode::kFloam;
};

}  // namespace isthmus::floam
