#include "tests/floam/building.h"

#include <utility>

namespace isthmus::floam::testing {
namespace {

constexpr double kFloorM = -1.2, kCeilingM = 2.8;

Cuboid Block(double x0, double y0, double x1, double y1, double top = kCeilingM) {
  return {{x0, y0, kFloorM}, {x1, y1, top}};
}

// Walls across the building at x = -6 and 6, with doorways.
Room Shell() {
  Room room;
  room.walls = {{-18, -6, kFloorM}, {18, 6, kCeilingM}};
  for (const double x : {-6.0, 6.0}) {
    room.boxes.push_back(Block(x - 0.1, -6, x + 0.1, -0.9));
    room.boxes.push_back(Block(x - 0.1, 0.9, x + 0.1, 6));
  }
  return room;
}

std::vector<Cuboid> LeftFurniture() {
  return {Block(-18, 4.2, -15.5, 6, 0.9), Block(-12.3, -3.4, -11.5, -2.6),
          Block(-9.5, 3.1, -8.7, 3.9), Block(-17, -6, -13.2, -5.3, 1.4),
          Block(-14.8, 1.5, -14.1, 2.6, 0.4)};
}

}  // namespace

Room ThreeRooms() {
  Room room = Shell();
  for (const Cuboid& box : LeftFurniture()) room.boxes.push_back(box);
  for (const Cuboid& box :
       {Block(-3.1, 2.2, -2.2, 3.1), Block(2.6, -4.4, 3.3, -3.1), Block(-1.2, -6, 1.9, -5.2, 1.1),
        Block(8.1, -4.8, 9.4, -4.1, 0.8), Block(13.3, 2.0, 14.1, 2.8),
        Block(16.2, -6, 18, -2.5, 1.2), Block(10.2, 4.9, 12.8, 6, 2.0)}) {
    room.boxes.push_back(box);
  }
  return room;
}

Room SymmetricRooms() {
  Room room = Shell();
  std::vector<Cuboid> half = LeftFurniture();
  half.push_back(Block(-3.1, 2.2, -2.2, 3.1));
  for (const Cuboid& box : half) {
    room.boxes.push_back(box);
    room.boxes.push_back(
        Block(-box.max.x(), -box.max.y(), -box.min.x(), -box.min.y(), box.max.z()));
  }
  return room;
}

Room OtherBuilding() {
  Room room;
  room.walls = {{-11, -9, kFloorM}, {14, 8, kCeilingM}};
  room.boxes = {Block(-4, -9, -3.8, 1.5),  Block(-3.8, 4, 5, 4.2),    Block(5, -2, 5.2, 8),
                Block(8.5, -6, 9.5, -5),   Block(-8, 4.5, -6.5, 5.2), Block(1, -5.5, 2.4, -4, 0.7),
                Block(10, 3, 14, 3.8, 1.3)};
  return room;
}

Scan StandingScan(const Room& room, const Pose& T_world_sensor, int index) {
  return MakeScan(
      room, [&](double) { return T_world_sensor; }, Sensor(), index);
}

Submap MapFrom(const Room& room, const std::vector<Pose>& T_world_sensor, uint32_t index) {
  Submap submap;
  submap.id.index = index;
  for (const Pose& pose : T_world_sensor) {
    const auto keyframe = static_cast<uint16_t>(submap.keyframes.size());
    const Scan scan = StandingScan(room, pose, static_cast<int>(1000 * index) + keyframe);
    submap.keyframes.push_back({scan.sequence, scan.end_stamp_ns, pose});
    for (const ScanPoint& p : scan.points) {
      const Eigen::Vector3f q = (pose * Eigen::Vector3d(p.x, p.y, p.z)).cast<float>();
      submap.points.push_back({q.x(), q.y(), q.z(), p.intensity, keyframe});
    }
  }
  return submap;
}

std::vector<Pose> AlongTheAxis(double from_x, double to_x) {
  std::vector<Pose> poses;
  for (double x = from_x; x <= to_x; x += 1) {
    poses.push_back(Pose::FromXyzRpy(x, 0.2, 0, 0, 0, 0));
  }
  return poses;
}

}  // namespace isthmus::floam::testing
