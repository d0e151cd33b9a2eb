// A robot: opens a session, streams scans, hears where it is.
//
//   example_02_push_scans [ADDRESS]
//
// The scans here are of a room that is made up: walls 6 m and 4 m away, seen by a sensor of 16
// rings that creeps forward. A real robot has its driver's clouds instead; see MakePayload in
// isthmus/core/codec/payload_builder.h, or fill a PointPayload field by field from a PointCloud2.
#include <isthmus/client/client.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace {

const Eigen::Vector3d kRoomMin(-6.2, -4.3, -1.1), kRoomMax(7.3, 5.2, 1.7);

isthmus::Scan LookAround(int index) {
  constexpr double kPi = 3.14159265358979;
  const Eigen::Vector3d sensor(0.1 * index, 0, 0);
  isthmus::Scan scan;
  scan.end_stamp_ns = 1'700'000'000'000'000'000 + index * 100'000'000LL;
  scan.has_ring = scan.has_time = true;
  for (int column = 0; column < 900; ++column) {
    const double azimuth = kPi - 2 * kPi * column / 900;
    for (int ring = 0; ring < 16; ++ring) {
      const double elevation = (-15 + 2 * ring) * kPi / 180;
      const Eigen::Vector3d ray(std::cos(elevation) * std::cos(azimuth),
                                std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
      // The nearest of the box's sides.
      double range = 1e9;
      for (int axis = 0; axis < 3; ++axis) {
        const double side = (ray[axis] > 0 ? kRoomMax : kRoomMin)[axis] - sensor[axis];
        if (ray[axis] != 0) range = std::min(range, side / ray[axis]);
      }
      isthmus::ScanPoint point;
      point.x = static_cast<float>(range * ray.x());
      point.y = static_cast<float>(range * ray.y());
      point.z = static_cast<float>(range * ray.z());
      point.ring = static_cast<uint16_t>(ring);
      point.time = static_cast<float>(-0.1 * (899 - column) / 900);  // Before the END of the scan.
      scan.points.push_back(point);
    }
  }
  return scan;
}

}  // namespace

int main(int argc, char** argv) {
  using namespace isthmus;
  using namespace isthmus::client;
  const auto client = Client::Connect({.address = argc > 1 ? argv[1] : "localhost:50051"});
  if (!client.ok()) return std::fprintf(stderr, "%s\n", client.status().ToString().c_str()), 1;
  const auto session = (*client)->CreateSession("alice", "vlp16");
  if (!session.ok()) return std::fprintf(stderr, "%s\n", session.status().ToString().c_str()), 1;

  ScanStreamOptions options;
  options.on_ack = [](const ScanAck& ack) {
    if (!ack.T_odom_sensor) return;
    const Eigen::Vector3d& p = ack.T_odom_sensor->translation();
    std::printf("scan %zu: %.2f %.2f %.2f, tracking %s, %.1f ms\n",
                static_cast<size_t>(ack.sequence), p.x(), p.y(), p.z(), ToString(ack.tracking),
                ack.timing.total_ms);
  };
  const auto stream = (*client)->OpenScanStream(session->record.id, options);
  if (!stream.ok()) return std::fprintf(stderr, "%s\n", stream.status().ToString().c_str()), 1;
  absl::Status status;
  for (int i = 0; i < 20 && status.ok(); ++i) status = (*stream)->Push(LookAround(i));
  if (status.ok()) status = (*stream)->Finish();  // Every scan has been acknowledged.
  if (status.ok()) status = (*client)->FinishSession(session->record.id).status();
  if (!status.ok()) std::fprintf(stderr, "%s\n", status.ToString().c_str());
  return status.ok() ? 0 : 1;
}
