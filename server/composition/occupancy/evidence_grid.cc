#include "server/composition/occupancy/evidence_grid.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "server/composition/occupancy/voxel_ray.h"
#include "server/composition/voxel_thinner.h"

namespace isthmus::composition {

EvidenceGrid::EvidenceGrid(const OccupancyOptions& options, uint64_t max_bytes, Planner planner)
    : resolution_m_(options.resolution_m),
      max_range_m_(options.max_range_m),
      hit_(LogOdds(options.sensor.hit)),
      miss_(LogOdds(options.sensor.miss)),
      least_(LogOdds(options.sensor.least)),
      most_(LogOdds(options.sensor.most)),
      max_bytes_(max_bytes),
      planner_(std::move(planner)) {}

VoxelIndex EvidenceGrid::IndexOf(const Eigen::Vector3d& p) const {
  return (p / resolution_m_).array().floor().cast<int32_t>();
}

EvidenceGrid::Column& EvidenceGrid::Make(const ColumnKey& key) {
  std::unique_ptr<Column>& column = columns_[key];
  if (column != nullptr) return *column;
  column = std::make_unique<Column>();
  column->key = key;
  bytes_ += sizeof(Column);
  const Plan plan = planner_(key);
  if (plan.from == Plan::kNever) return *column;
  if (end_ && key >= *end_) {
    ++given_up_;
    return *column;
  }
  column->from = plan.from;
  if (plan.kept == nullptr) return *column;
  plan.kept->Unpack(1, &column->voxels);
  bytes_ += column->voxels.bytes();
  return *column;
}

EvidenceGrid::Column& EvidenceGrid::Touch(const VoxelIndex& index) {
  const ColumnKey key = ColumnOf(index);
  if (last_ == nullptr || last_->key != key) last_ = &Make(key);
  if (last_->touched != submap_) {
    last_->touched = submap_;
    last_->is_changed = last_->is_changed || Takes(*last_);
    touched_.push_back(key);
  }
  return *last_;
}

bool EvidenceGrid::Update(const VoxelIndex& index, float evidence, Column* column) {
  const uint64_t before = column->voxels.bytes();
  VoxelCell& cell = column->voxels.At(index);
  bytes_ += column->voxels.bytes() - before;
  if (cell.scan == scan_) return false;
  cell.scan = scan_;
  cell.log_odds = std::clamp(cell.log_odds + evidence, least_, most_);
  return true;
}

void EvidenceGrid::BeginSubmap(uint32_t number) {
  submap_ = number;
  touched_.clear();
}

bool EvidenceGrid::InsertScan(const Eigen::Vector3d& origin,
                              const std::vector<Eigen::Vector3d>& points) {
  ++scan_;
  ray_ends_.clear();
  ends_.clear();
  // Hits first: a miss of the same scan then finds its voxel taken.
  for (const Eigen::Vector3d& p : points) {
    const Eigen::Vector3d ray = p - origin;
    const double range = ray.norm();
    if (!std::isfinite(range)) continue;
    const bool hit = range <= max_range_m_;
    const VoxelIndex index = IndexOf(hit ? p : origin + ray * (max_range_m_ / range));
    Column* column = hit ? &Touch(index) : nullptr;
    const bool changes = column != nullptr && Takes(*column);
    const bool is_new = changes ? Update(index, hit_, column)
                                : ends_.insert(PackVoxel({index.x(), index.y(), index.z()})).second;
    // One ray per voxel, to its middle, whichever of its points came first.
    if (is_new) ray_ends_.push_back(index);
  }
  for (const VoxelIndex& end : ray_ends_) {
    ClearRay(origin, end);
    if (bytes_ > max_bytes_ && !GiveUpSome()) return false;
  }
  return true;
}

void EvidenceGrid::ClearRay(const Eigen::Vector3d& from, const VoxelIndex& last) {
  const Eigen::Vector3d to = (last.cast<double>().array() + 0.5) * resolution_m_;
  VoxelRay ray(from, to, IndexOf(from), last, resolution_m_);
  while (!ray.done()) {
    Column& column = Touch(ray.index());
    if (!Takes(column)) {
      ray.LeaveColumn();
      continue;
    }
    do {
      Update(ray.index(), miss_, &column);
      ray.Step();
    } while (!ray.done() && ColumnOf(ray.index()) == column.key);
  }
}

std::vector<ColumnKey> EvidenceGrid::Touched() const {
  std::vector<ColumnKey> touched = touched_;
  std::sort(touched.begin(), touched.end());
  return touched;
}

// Half of what there is room for stays: the rest fills up again.
bool EvidenceGrid::GiveUpSome() {
  std::vector<Column*> taken;
  for (const auto& [key, column] : columns_) {
    if (column->from != Plan::kNever) taken.push_back(column.get());
  }
  std::sort(taken.begin(), taken.end(),
            [](const Column* a, const Column* b) { return a->key < b->key; });
  uint64_t kept = 0;
  size_t count = 0;
  for (; count < taken.size(); ++count) {
    kept += taken[count]->voxels.bytes();
    if (count > 0 && kept > max_bytes_ / 2) break;
  }
  if (count == taken.size()) return false;
  end_ = taken[count]->key;
  given_up_ += taken.size() - count;
  for (; count < taken.size(); ++count) {
    taken[count]->from = Plan::kNever;
    bytes_ -= taken[count]->voxels.bytes();
    taken[count]->voxels = VoxelColumn();
  }
  return bytes_ <= max_bytes_;
}

void EvidenceGrid::TakeEach(const std::function<void(const ColumnKey&, PackedColumn)>& visit) {
  for (auto& [key, column] : columns_) {
    if (column->from != Plan::kNever && column->is_changed) {
      visit(key, PackedColumn(column->voxels));
    }
    column.reset();
  }
  columns_.clear();
  last_ = nullptr;
  bytes_ = 0;
}

}  // namespace isthmus::composition
