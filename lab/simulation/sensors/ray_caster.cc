#include "lab/simulation/sensors/ray_caster.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>
#include <cstring>

namespace isthmus::simulation {

namespace {

// A thin ramp is a floor above and a ceiling below.
PointClass SeenAlong(const Eigen::Vector3f& direction, const Eigen::Vector3f& normal,
                     PointClass surface) {
  const bool from_below = normal.z() * normal.dot(direction) > 0;
  return surface == PointClass::kGround && from_below ? PointClass::kCeiling : surface;
}

}  // namespace

struct RayCaster::Scene {
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
  std::vector<Material> materials;  // By triangle, as the next.
  std::vector<PointClass> classes;

  ~Scene() {
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
  }
};

RayCaster::RayCaster(const Mesh& mesh) : scene_(std::make_unique<Scene>()) {
  scene_->device = rtcNewDevice("threads=1,set_affinity=0");
  scene_->scene = rtcNewScene(scene_->device);
  scene_->materials = mesh.materials;
  scene_->classes = mesh.classes;
  RTCGeometry geometry = rtcNewGeometry(scene_->device, RTC_GEOMETRY_TYPE_TRIANGLE);
  void* vertices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                           3 * sizeof(float), mesh.vertices.size());
  void* triangles = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                            3 * sizeof(uint32_t), mesh.triangles.size());
  // A world with nothing in it has null buffers.
  if (vertices != nullptr && triangles != nullptr && !mesh.triangles.empty()) {
    std::memcpy(vertices, mesh.vertices.front().data(), mesh.vertices.size() * 3 * sizeof(float));
    std::memcpy(triangles, mesh.triangles.data(), mesh.triangles.size() * 3 * sizeof(uint32_t));
  }
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene_->scene, geometry);
  rtcReleaseGeometry(geometry);
  // Robust: a ray never slips through the edge between two triangles.
  rtcSetSceneFlags(scene_->scene, RTC_SCENE_FLAG_ROBUST);
  rtcCommitScene(scene_->scene);
}

RayCaster::~RayCaster() = default;

void RayCaster::Cast(std::span<const Ray> rays, float max_range_m, std::span<Hit> hits) const {
  constexpr size_t kPacket = 16;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  alignas(64) RTCRayHit16 packet;
  alignas(64) int valid[kPacket];
  for (size_t first = 0; first < rays.size(); first += kPacket) {
    const size_t count = std::min(kPacket, rays.size() - first);
    for (size_t i = 0; i < kPacket; ++i) {
      valid[i] = i < count ? -1 : 0;
      const Ray& ray = rays[first + std::min(i, count - 1)];
      packet.ray.org_x[i] = ray.origin.x();
      packet.ray.org_y[i] = ray.origin.y();
      packet.ray.org_z[i] = ray.origin.z();
      packet.ray.dir_x[i] = ray.direction.x();
      packet.ray.dir_y[i] = ray.direction.y();
      packet.ray.dir_z[i] = ray.direction.z();
      packet.ray.tnear[i] = 0;
      packet.ray.tfar[i] = max_range_m;
      packet.ray.time[i] = 0;
      packet.ray.mask[i] = ~0u;
      packet.ray.flags[i] = 0;
      packet.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
      packet.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
    }
    rtcIntersect16(valid, scene_->scene, &context, &packet);
    for (size_t i = 0; i < count; ++i) {
      Hit& hit = hits[first + i];
      hit = {};
      if (packet.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) continue;
      const Eigen::Vector3f normal(packet.hit.Ng_x[i], packet.hit.Ng_y[i], packet.hit.Ng_z[i]);
      hit.range_m = packet.ray.tfar[i];
      hit.normal = normal.normalized();
      const Eigen::Vector3f& direction = rays[first + i].direction;
      hit.cosine = std::abs(hit.normal.dot(direction));
      hit.material = scene_->materials[packet.hit.primID[i]];
      hit.surface = SeenAlong(direction, hit.normal, scene_->classes[packet.hit.primID[i]]);
    }
  }
}

}  // namespace isthmus::simulation
