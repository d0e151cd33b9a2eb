// A session's map as the bird's-eye search and the free-space check need it, made once: walls and
// ground in a level frame, and where the robot looked through.
#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>
#include <map>
#include <memory>
#include <vector>

#include "core/concurrency/mutex.h"
#include "core/map/submap.h"
#include "core/pose.h"
#include "server/matching/registration/surface.h"
#include "server/matching/search/ground_grid.h"

namespace isthmus::matching {

// Metres above the local ground.
struct HeightBand {
  float low = 0, high = 0;
};

// The scales on which a place is compared. Indoors rooms are small and low; outdoors cars, people
// and hedges fill what is near the ground, and walls are high.
struct SceneScale {
  bool outdoors = false;
  double cell_m = 0.25;         // Cell of the bird's-eye image.
  HeightBand wall{0.6f, 3.5f};  // A near-vertical surface in this band is a wall.
  HeightBand free{0.6f, 2.2f};  // A ray in this band shows that there is none.
  float max_range_m = 30;       // Reach of rays and walls from the robot's places.

  static SceneScale Indoors() { return {}; }
  static SceneScale Outdoors() { return {true, 0.5, {1.5f, 8.0f}, {1.0f, 4.0f}, 40}; }
};

struct WallPoint {
  Eigen::Vector3f position;  // Level frame.
  Eigen::Vector2f normal;    // Level frame, towards the sensor, unit length.
  float height = 0;          // Above the local ground.
};

// A horizontal stretch that was seen to be free at wall height, level frame.
struct FreeRay {
  Eigen::Vector2f from, to;
};

// Outdoors there are no ceilings, and a good part of what is seen is far from wherever the robot
// was; a sensor that looks ahead sees no ceiling in a small room either. `surface` within about 15
// degrees of level; `sensors` in the same frame.
bool IsOutdoors(const std::vector<SurfacePoint>& surface,
                const std::vector<Eigen::Vector3f>& sensors);

// Positions of the keyframes' sensors, odom frame.
std::vector<Eigen::Vector3f> SensorPositions(const SessionMap& map);
// Appends those of one submap.
void AddSensorPositions(const Submap& submap, std::vector<Eigen::Vector3f>* sensors);

// Immutable; safe to read from many threads.
class WallMap {
 public:
  // `surface` as sampled from the map (SampleSurface), odom frame; `T_level_odom` a rotation.
  WallMap(const SessionMap& map, const std::vector<SurfacePoint>& surface,
          const Pose& T_level_odom);
  // The level is estimated from the surface.
  WallMap(const SessionMap& map, const std::vector<SurfacePoint>& surface);

  bool outdoors() const { return outdoors_; }
  // Pure rotation: the level frame has odom's origin, z up.
  const Pose& T_level_odom() const { return T_level_odom_; }
  const GroundGrid& ground() const { return ground_; }
  // Heights of storeys above the lowest floor: 0, and where others have floors of some extent. Of
  // maps under the open sky only 0.
  const std::vector<float>& storeys() const { return storeys_; }
  // Near-vertical surfaces of any height.
  const std::vector<WallPoint>& walls() const { return walls_; }
  // Keyframes' sensor positions, level frame.
  const std::vector<Eigen::Vector3f>& sensors() const { return sensors_; }
  // Their mean in the odom frame; its origin where there are none.
  Eigen::Vector3d MeanSensor() const;
  // Called for each measured point of the keyframes whose rays are kept: its position, its height
  // above the local ground, and its distance from the keyframe, seen from above.
  using Visitor = std::function<void(const Eigen::Vector2f& at, float height, float range)>;
  void VisitEnds(const Visitor& visit) const;
  // Rays of the keyframes within the band. Made when first asked for, kept.
  const std::vector<FreeRay>& FreeRays(const SceneScale& scale) const;

 private:
  struct KeyframeEnds {
    Eigen::Vector3f sensor;
    std::vector<Eigen::Vector3f> ends;  // Relative to the sensor.
  };
  struct KeptRays {
    Mutex mutex;
    // By the bounds of the band and the reach. What is there stays.
    std::map<std::array<float, 3>, std::vector<FreeRay>> by_scale ABSL_GUARDED_BY(mutex);
  };
  std::vector<FreeRay> MakeFreeRays(const SceneScale& scale) const;
  void CollectKeyframes(const SessionMap& map);
  void FindStoreys(const std::vector<SurfacePoint>& level);

  Pose T_level_odom_;
  bool outdoors_ = false;
  GroundGrid ground_;
  std::vector<float> storeys_ = {0};
  std::vector<WallPoint> walls_;
  std::vector<Eigen::Vector3f> sensors_;
  std::vector<KeyframeEnds> keyframes_;  // Thinned.
  std::unique_ptr<KeptRays> kept_rays_ = std::make_unique<KeptRays>();
};

}  // namespace isthmus::matching
