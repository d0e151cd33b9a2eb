// Damaged records of the store: edges, submaps, submaps made ready for matching, states of
// odometry.
//
// A record's checksum would stop all that is not one: the fuzzer's bytes are its body, which is
// given the right one. The first byte chooses the kind.
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "core/byte_stream.h"
#include "core/io/crc32c.h"
#include "core/state_codec.h"
#include "floam/odometry.h"
#include "floam/odometry_options.h"
#include "floam/rings/sensor_model.h"
#include "server/matching/prepared/prepared_submap_codec.h"
#include "storage/records/edge_codec.h"
#include "storage/records/submap_codec.h"

namespace isthmus {
namespace {

std::string Sealed(const std::string& magic, const std::string& body) {
  std::string blob = magic;
  AppendBytes(io::Crc32c(body.data(), body.size()), blob);
  return blob + body;
}

void TrySubmap(const std::string& body) {
  Submap submap;
  if (!storage::DecodeSubmap(Sealed("ISM1", body), submap).ok()) return;
  for (const SubmapPoint& point : submap.points) {
    if (point.keyframe >= submap.keyframes.size()) std::abort();
  }
}

void TryEdges(const std::string& body) {
  std::vector<SubmapEdge> edges;
  if (!storage::DecodeEdges(Sealed("IME1", body), edges).ok()) return;
  for (const SubmapEdge& edge : edges) {
    if (!edge.T_a_b.IsFinite()) std::abort();
  }
}

// In place of the state that a new odometry saves, with its header and the right checksum.
void TryOdometry(const std::string& body) {
  const auto sensor = floam::FindSensorModel("vlp16");
  floam::Odometry odometry(*sensor, {});
  constexpr size_t kHeader = 4 + 4 + 8;  // Magic, version, options; then the checksum.
  std::string sealed = odometry.Save().substr(0, kHeader);
  AppendBytes(StateChecksum(body.data(), body.size()), sealed);
  (void)odometry.Restore(sealed + body);
}

void TryPrepared(const std::string& bytes) {
  auto submap = std::make_shared<Submap>();
  submap->keyframes.resize(3);
  (void)matching::DecodePreparedSubmap(submap, bytes);
}

}  // namespace
}  // namespace isthmus

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace isthmus;
  if (size == 0) return 0;
  const std::string bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
  switch (data[0]) {
    case 's':
      TrySubmap(bytes);
      break;
    case 'e':
      TryEdges(bytes);
      break;
    case 'o':
      TryOdometry(bytes);
      break;
    default:
      TryPrepared(bytes);
      break;
  }
  return 0;
}
