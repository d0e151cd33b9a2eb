#include "core/formats/octomap_reader.h"

#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_split.h>
#include <absl/strings/strip.h>

#include <string_view>

namespace isthmus::formats {
namespace {

constexpr int kOctreeDepth = 16;
constexpr int32_t kOctreeMiddle = 1 << (kOctreeDepth - 1);

absl::Status BadOctomap(const std::string& why) {
  return absl::InvalidArgumentError(absl::StrCat("OctoMap: ", why));
}

// The meaning of two bits of a child.
enum class Child { kUnknown, kOccupied, kFree, kParent };

Child ChildOf(unsigned bits, int number) {
  const unsigned pair = bits >> 2 * number & 3;
  if (pair == 3) return Child::kParent;
  return pair == 0 ? Child::kUnknown : pair == 1 ? Child::kFree : Child::kOccupied;
}

class OctreeBody {
 public:
  OctreeBody(const std::string& bytes, size_t at,
             const std::function<void(const VoxelCube&)>& visit)
      : bytes_(bytes), at_(at), visit_(visit) {}

  // The children of a node whose lowest voxel that is; false where the bytes end.
  bool Read(const VoxelCube& node) {
    if (node.edge < 2 || bytes_.size() - at_ < 2) return false;
    const unsigned bits = static_cast<uint8_t>(bytes_[at_]) |
                          static_cast<unsigned>(static_cast<uint8_t>(bytes_[at_ + 1])) << 8;
    at_ += 2;
    for (const bool are_parents : {false, true}) {
      for (int number = 0; number < 8; ++number) {
        const Child child = ChildOf(bits, number);
        if (child == Child::kUnknown || (child == Child::kParent) != are_parents) continue;
        const int32_t half = node.edge / 2;
        const VoxelCube place{node.x + (number & 1 ? half : 0), node.y + (number & 2 ? half : 0),
                              node.z + (number & 4 ? half : 0), half, child == Child::kOccupied};
        if (!are_parents) {
          visit_(place);
        } else if (!Read(place)) {
          return false;
        }
      }
    }
    return true;
  }

 private:
  const std::string& bytes_;
  size_t at_;
  const std::function<void(const VoxelCube&)>& visit_;
};

}  // namespace

absl::StatusOr<double> ParseOctomapBinary(const std::string& bytes,
                                          const std::function<void(const VoxelCube&)>& visit) {
  constexpr std::string_view kFirst = "# Octomap OcTree binary file\n", kData = "\ndata\n";
  if (!bytes.starts_with(kFirst)) return BadOctomap("it does not begin as a .bt file");
  const size_t data = bytes.find(kData);
  if (data == std::string::npos) return BadOctomap("there is no line \"data\"");
  double resolution_m = 0;
  uint64_t nodes = 0;
  for (absl::string_view line : absl::StrSplit(bytes.substr(0, data), '\n')) {
    if (absl::ConsumePrefix(&line, "res ") && !absl::SimpleAtod(line, &resolution_m)) break;
    if (absl::ConsumePrefix(&line, "size ") && !absl::SimpleAtoi(line, &nodes)) break;
  }
  if (!(resolution_m > 0)) return BadOctomap("there is no resolution");
  if (nodes == 0) return resolution_m;
  OctreeBody body(bytes, data + kData.size(), visit);
  if (!body.Read({-kOctreeMiddle, -kOctreeMiddle, -kOctreeMiddle, 2 * kOctreeMiddle, false})) {
    return BadOctomap("the file ends early");
  }
  return resolution_m;
}

}  // namespace isthmus::formats
