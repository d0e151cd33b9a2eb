#include "server/classes/forest.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/asset.h"

namespace isthmus {

const Assets& OwnForest();  // The files of forest/.

namespace classes {
namespace {

// "IFOR", version 1; then the numbers of features, classes and trees, the power, the trees.
constexpr uint32_t kMagic = 0x524f4649, kVersion = 1;  // Format

class Reader {
 public:
  explicit Reader(absl::string_view bytes) : left_(bytes) {}

  // Zero beyond the end, after which is_good() is false.
  template <typename T>
  T Take() {
    T value = {};
    if (left_.size() < sizeof(T)) {
      is_good_ = false;
      left_ = {};
      return value;
    }
    std::memcpy(&value, left_.data(), sizeof(T));
    left_.remove_prefix(sizeof(T));
    return value;
  }
  bool is_good() const { return is_good_; }
  bool is_at_end() const { return left_.empty(); }

 private:
  absl::string_view left_;
  bool is_good_ = true;
};

}  // namespace

absl::StatusOr<Forest> Forest::Read(absl::string_view bytes) {
  const absl::Status damaged = absl::DataLossError("this is no forest for this program's features");
  Reader reader(bytes);
  if (reader.Take<uint32_t>() != kMagic || reader.Take<uint32_t>() != kVersion ||
      reader.Take<uint32_t>() != kFeatures || reader.Take<uint32_t>() != kPointClasses) {
    return damaged;
  }
  Forest forest;
  auto trees = reader.Take<uint32_t>();
  const auto power = reader.Take<float>();
  if (!(power > 0 && power < 100)) return damaged;
  for (size_t i = 0; i < forest.sharpened_.size(); ++i) {
    forest.sharpened_[i] = std::pow(static_cast<float>(i) / 255, power);
  }
  for (; trees > 0 && reader.is_good(); --trees) {
    Tree& tree = forest.trees_.emplace_back();
    const auto nodes = reader.Take<uint16_t>(), leaves = reader.Take<uint16_t>();
    for (int i = 0; i < nodes && reader.is_good(); ++i) {
      Node& node = tree.nodes.emplace_back();
      node.threshold = reader.Take<float>();
      node.feature = reader.Take<uint16_t>();
      node.next = reader.Take<uint16_t>();
      // Children come later, so that every way ends.
      const bool is_leaf = node.feature == kLeaf;
      const bool is_right =
          is_leaf ? node.next < leaves
                  : node.feature < kFeatures && node.next > i && node.next + 1 < nodes;
      if (!is_right) return damaged;
    }
    for (int i = 0; i < leaves && reader.is_good(); ++i) {
      tree.leaves.push_back(reader.Take<std::array<uint8_t, kPointClasses>>());
    }
    if (tree.nodes.empty()) return damaged;
  }
  if (!reader.is_good() || !reader.is_at_end() || forest.trees_.empty()) return damaged;
  return forest;
}

const Forest& Forest::Own() {
  static const Forest forest = Read(OwnForest().front().content).value();
  return forest;
}

Shares Forest::Tell(const Features& features) const {
  std::array<uint32_t, kPointClasses> sums = {};
  for (const Tree& tree : trees_) {
    const Node* node = tree.nodes.data();
    while (node->feature != kLeaf) {
      node = &tree.nodes[node->next + (features[node->feature] > node->threshold ? 1U : 0U)];
    }
    const auto& leaf = tree.leaves[node->next];
    for (size_t i = 0; i < sums.size(); ++i) sums[i] += leaf[i];
  }
  Shares shares;
  float sum = 0;
  for (size_t i = 0; i < sums.size(); ++i) {
    shares[i] = sharpened_[sums[i] / trees_.size()];
    sum += shares[i];
  }
  for (float& share : shares) share /= std::max(sum, std::numeric_limits<float>::min());
  return shares;
}

}  // namespace classes
}  // namespace isthmus
