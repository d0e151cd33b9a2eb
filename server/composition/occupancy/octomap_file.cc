#include "server/composition/occupancy/octomap_file.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>
#include <span>
#include <sstream>

#include "server/composition/occupancy/sensor_evidence.h"

namespace isthmus::composition {
namespace {

constexpr int kCubeDepth = kTreeDepth - kColumnBits;  // Format: of nodes that are cubes.

struct PlacedCube {
  uint64_t order = 0;  // Bits of its place, x, y and z in turn, as children are numbered.
  const PackedColumn* column = nullptr;
  PackedColumn::Cube cube;
};

uint64_t OrderOf(const ColumnKey& key, int32_t z) {
  uint64_t order = 0;
  for (int bit = 0; bit < kCubeDepth; ++bit) {
    const auto at = [bit](int32_t i) {
      return static_cast<uint64_t>((i + (1 << (kCubeDepth - 1))) >> bit & 1);
    };
    order |= (at(key.x) | at(key.y) << 1 | at(z) << 2) << 3 * bit;
  }
  return order;
}

std::vector<PlacedCube> InOrder(const std::vector<PlacedColumn>& columns) {
  std::vector<PlacedCube> cubes;
  for (const PlacedColumn& placed : columns) {
    for (const PackedColumn::Cube& cube : placed.column->cubes()) {
      cubes.push_back({OrderOf(placed.key, cube.z), placed.column.get(), cube});
    }
  }
  std::sort(cubes.begin(), cubes.end(),
            [](const PlacedCube& a, const PlacedCube& b) { return a.order < b.order; });
  return cubes;
}

// The place of a node's child.
VoxelCube ChildAt(const VoxelCube& node, int child) {
  const int32_t half = node.edge / 2;
  return {node.x + (child & 1 ? half : 0), node.y + (child & 2 ? half : 0),
          node.z + (child & 4 ? half : 0), half};
}

// A tree of what is likelier, free or occupied.
class LikeliestBody {
 public:
  enum State : uint32_t { kUnknown = 0, kFree = 1, kOccupied = 2, kInner = 3 };
  using Node = State;

  void BeginColumn(const std::vector<float>& levels) {
    states_.clear();
    for (const float level : levels) {
      states_.push_back(level >= kOccupiedLogOdds ? kOccupied : kFree);
    }
  }
  Node Leaf(uint32_t level) const { return states_[level]; }

  struct Open {
    size_t begin = 0;
    uint32_t children = 0;  // Two bits for each.
  };

 protected:
  static constexpr uint32_t kAllFree = 0x5555, kAllOccupied = 0xaaaa;  // Format
  static bool AreAlike(const Open& open) {
    return open.children == kAllFree || open.children == kAllOccupied;
  }

 private:
  std::vector<State> states_;  // One for each level of the column.
};

// OcTree::writeBinaryNode: two bits for each child, then the inner ones.
class BinaryBody : public LikeliestBody {
 public:
  explicit BinaryBody(std::string* bytes) : bytes_(bytes) {}

  Open Begin() {
    const size_t begin = bytes_->size();
    bytes_->append(2, '\0');
    return {begin};
  }
  void Add(int child, Node node, const VoxelCube&, Open* open) {
    open->children |= static_cast<uint32_t>(node) << 2 * child;
  }
  // Removes the children again if all are alike, unless the node is the root.
  Node End(const Open& open, bool is_root) {
    if (AreAlike(open) && !is_root) {
      bytes_->resize(open.begin);
      return open.children == kAllFree ? kFree : kOccupied;
    }
    nodes_ += std::popcount((open.children | open.children >> 1) & kAllFree);
    (*bytes_)[open.begin] = static_cast<char>(open.children);
    (*bytes_)[open.begin + 1] = static_cast<char>(open.children >> 8);
    return kInner;
  }
  uint64_t nodes() const { return nodes_ + 1; }  // The root is nobody's child.
  uint64_t size() const { return bytes_->size(); }

 private:
  std::string* const bytes_;
  uint64_t nodes_ = 0;
};

// The leaves that BinaryBody writes, without the bytes.
class CubesBody : public LikeliestBody {
 public:
  explicit CubesBody(std::vector<VoxelCube>* cubes) : cubes_(*cubes) {}

  Open Begin() const { return {cubes_.size()}; }
  void Add(int child, Node node, const VoxelCube& place, Open* open) {
    open->children |= static_cast<uint32_t>(node) << 2 * child;
    if (node == kInner) return;
    cubes_.push_back(place);
    cubes_.back().is_occupied = node == kOccupied;
  }
  Node End(const Open& open, bool is_root) {
    if (!AreAlike(open) || is_root) {
      size_ += 2;
      return kInner;
    }
    cubes_.resize(open.begin);
    return open.children == kAllFree ? kFree : kOccupied;
  }
  uint64_t size() const { return size_; }

 private:
  std::vector<VoxelCube>& cubes_;
  uint64_t size_ = 0;  // Bytes that the tree has in a file.
};

// OcTreeBaseImpl::writeNodesRecurs: each node's log-odds, inner ones with the most of their
// children, and a bit for each child, then the children.
class FullBody {
 public:
  struct Node {
    bool is_leaf = false;
    float log_odds = 0;
  };

  explicit FullBody(std::string* bytes) : bytes_(bytes) {}

  void BeginColumn(const std::vector<float>& levels) { levels_ = &levels; }
  Node Leaf(uint32_t level) const { return {true, (*levels_)[level]}; }

  struct Open {
    size_t begin = 0;
    uint32_t children = 0;
    float most = std::numeric_limits<float>::lowest(), first = 0;
    bool alike = true;
  };
  Open Begin() {
    const size_t begin = bytes_->size();
    bytes_->append(kNodeBytes, '\0');
    return {begin};
  }
  void Add(int child, const Node& node, const VoxelCube&, Open* open) {
    open->children |= 1u << child;
    open->most = std::max(open->most, node.log_odds);
    if (child == 0) open->first = node.log_odds;
    open->alike = open->alike && node.is_leaf && node.log_odds == open->first;
    if (!node.is_leaf) return;
    const size_t begin = bytes_->size();
    bytes_->append(kNodeBytes, '\0');
    std::memcpy(bytes_->data() + begin, &node.log_odds, sizeof(float));
  }
  Node End(const Open& open, bool is_root) {
    constexpr uint32_t kAll = 0xff;
    if (open.children == kAll && open.alike && !is_root) {
      bytes_->resize(open.begin);
      return {true, open.first};
    }
    std::memcpy(bytes_->data() + open.begin, &open.most, sizeof(float));
    (*bytes_)[open.begin + sizeof(float)] = static_cast<char>(open.children);
    return {false, open.most};
  }
  uint64_t nodes() const { return bytes_->size() / kNodeBytes; }
  uint64_t size() const { return bytes_->size(); }

 private:
  static constexpr size_t kNodeBytes = sizeof(float) + 1;  // Format

  std::string* const bytes_;
  const std::vector<float>* levels_ = nullptr;
};

template <typename Body>
typename Body::Node AddInner(const VoxelCube& place, const uint8_t** at, Body* body) {
  const uint32_t children = TakeChildren(at);
  typename Body::Open open = body->Begin();
  for (int child = 0; child < kChildren; ++child) {
    const Branch branch = ChildOf(children, child);
    if (branch == Branch::kUnknown) continue;
    const VoxelCube there = ChildAt(place, child);
    body->Add(child,
              branch == Branch::kLeaf ? body->Leaf(TakeLevel(at)) : AddInner(there, at, body),
              there, &open);
  }
  return body->End(open, false);
}

// More than the limit was written: nothing more is.
struct Limit {
  uint64_t most = 0;
  bool is_passed = false;
};

// Adds the node at this depth and place that has all the cubes below it.
template <typename Body>
typename Body::Node AddNode(std::span<const PlacedCube> cubes, int depth, const VoxelCube& place,
                            Limit* limit, Body* body) {
  if (depth == kCubeDepth) {
    limit->is_passed = limit->is_passed || body->size() > limit->most;
    if (limit->is_passed) return {};
    const PlacedCube& placed = cubes.front();
    body->BeginColumn(placed.column->levels());
    const uint8_t* at = placed.column->BytesOf(placed.cube);
    const auto branch = static_cast<Branch>(*at++);
    return branch == Branch::kLeaf ? body->Leaf(TakeLevel(&at)) : AddInner(place, &at, body);
  }
  typename Body::Open open = body->Begin();
  const int shift = 3 * (kCubeDepth - 1 - depth);
  while (!cubes.empty()) {
    const int child = static_cast<int>(cubes.front().order >> shift & 7);
    size_t count = 1;
    while (count < cubes.size() && static_cast<int>(cubes[count].order >> shift & 7) == child) {
      ++count;
    }
    const VoxelCube there = ChildAt(place, child);
    body->Add(child, AddNode(cubes.first(count), depth + 1, there, limit, body), there, &open);
    cubes = cubes.subspan(count);
  }
  return body->End(open, depth == 0);
}

// ResourceExhausted where it has more than so many bytes.
template <typename Body>
absl::Status AddTree(const std::vector<PlacedColumn>& columns, uint64_t max_bytes, Body* body) {
  constexpr int32_t kMiddle = 1 << (kTreeDepth - 1);
  const std::vector<PlacedCube> cubes = InOrder(columns);
  Limit limit{max_bytes};
  const VoxelCube root{-kMiddle, -kMiddle, -kMiddle, 2 * kMiddle};
  if (!cubes.empty()) AddNode<Body>(cubes, 0, root, &limit, body);
  if (!limit.is_passed && body->size() <= max_bytes) return absl::OkStatus();
  return absl::ResourceExhaustedError(
      absl::StrCat("the file would have more than ", max_bytes >> 20, " MB"));
}

// The first lines are what readers know the formats by.
std::string HeaderOf(OccupancyFormat format, uint64_t nodes, double resolution_m) {
  std::ostringstream header;
  header << (format == OccupancyFormat::kBinary
                 ? "# Octomap OcTree binary file\n"
                 : "# Octomap OcTree file\n# (feel free to add / change comments, but leave the "
                   "first line as it is!)\n#\n")
         << "id OcTree\nsize " << nodes << "\nres " << resolution_m << "\ndata\n";
  return std::move(header).str();
}

template <typename Body>
absl::StatusOr<std::string> Format(const std::vector<PlacedColumn>& columns, OccupancyFormat format,
                                   double resolution_m, uint64_t max_bytes) {
  std::string bytes;
  Body body(&bytes);
  if (absl::Status status = AddTree(columns, max_bytes, &body); !status.ok()) return status;
  bytes.insert(0, HeaderOf(format, bytes.empty() ? 0 : body.nodes(), resolution_m));
  return bytes;
}

}  // namespace

absl::StatusOr<std::string> FormatOctomap(const std::vector<PlacedColumn>& columns,
                                          OccupancyFormat format, double resolution_m,
                                          uint64_t max_bytes) {
  return format == OccupancyFormat::kBinary
             ? Format<BinaryBody>(columns, format, resolution_m, max_bytes)
             : Format<FullBody>(columns, format, resolution_m, max_bytes);
}

absl::StatusOr<std::vector<VoxelCube>> OctomapCubes(const std::vector<PlacedColumn>& columns,
                                                    uint64_t max_bytes) {
  std::vector<VoxelCube> cubes;
  CubesBody body(&cubes);
  if (absl::Status status = AddTree(columns, max_bytes, &body); !status.ok()) return status;
  return cubes;
}

}  // namespace isthmus::composition
