// A robot with a SLAM of its own: uploads finished submaps, asks where another robot is, and reads
// the points around that place.
//
//   example_04_upload_submaps ADDRESS OTHER_ROBOT SUBMAP.pcd [SUBMAP.pcd ...]
//
// All PCD files are taken to be in the robot's odom frame.
#include <isthmus/client/client.h>
#include <isthmus/core/formats/pcd.h>

#include <cstdio>
#include <string>

namespace {

using namespace isthmus;
using namespace isthmus::client;

absl::Status Upload(Client& client, int files, char** names) {
  const auto session = client.CreateSession("carol", "vlp16");
  if (!session.ok()) return session.status();
  for (int i = 0; i < files; ++i) {
    auto pcd = isthmus::formats::ReadPcd(names[i]);
    if (!pcd.ok()) return pcd.status();
    SubmapUpload submap;
    submap.id = {session->record.id, static_cast<uint32_t>(i)};
    submap.keyframes = {{0, pcd->viewpoint}};  // The sensor's place: normals turn to it.
    submap.cloud = std::move(pcd->payload);
    const absl::Status status = client.UploadSubmap(submap);
    if (!status.ok()) return status;
  }
  return client.FinishSession(session->record.id).status();
}

absl::Status LookAt(Client& client, const std::string& other) {
  const RobotId carol("carol"), robot(other);
  const auto transform = client.GetTransform(carol, robot);
  if (!transform.ok()) return transform.status();  // FailedPrecondition: not yet; says why.
  const Eigen::Vector3d& p = transform->T_a_b.translation();
  std::printf("%s set out from %.2f %.2f %.2f\n", other.c_str(), p.x(), p.y(), p.z());

  const auto trajectory = client.GetTrajectory(robot, TrajectoryFrame::kMap);
  if (!trajectory.ok()) return trajectory.status();
  if (trajectory->poses.empty()) return absl::OkStatus();
  RegionQuery query;
  query.sphere = {trajectory->poses.back().pose.translation(), 10};
  query.component = trajectory->component;
  query.resolution_m = 0.2;
  size_t points = 0;
  const absl::Status status = client.QueryRegion(query, [&](const RegionChunk& chunk) {
    points += chunk.points.size();
    return true;
  });
  std::printf("%zu points within 10 m of it now\n", points);
  return status;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 4) {
    std::fprintf(stderr, "usage: %s ADDRESS OTHER_ROBOT SUBMAP.pcd [...]\n", argv[0]);
    return 2;
  }
  const auto client = Client::Connect({.address = argv[1]});
  absl::Status status = client.status();
  if (status.ok()) status = Upload(**client, argc - 3, argv + 3);
  if (status.ok()) status = LookAt(**client, argv[2]);
  if (!status.ok()) std::fprintf(stderr, "%s\n", status.ToString().c_str());
  return status.ok() ? 0 : 1;
}
