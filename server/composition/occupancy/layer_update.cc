#include "server/composition/occupancy/layer_update.h"

#include <absl/container/flat_hash_map.h>
#include <absl/hash/hash.h>
#include <absl/strings/str_cat.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "server/composition/occupancy/evidence_grid.h"
#include "server/composition/occupancy/limits.h"
#include "server/composition/thinned_submap.h"

namespace isthmus::composition {
namespace {

absl::Status CheckReach(const Eigen::Vector3d& origin, const OccupancyOptions& options) {
  const double reach = (1 << (kTreeDepth - 1)) * options.resolution_m;
  const double needed = origin.cwiseAbs().maxCoeff() + options.max_range_m + options.resolution_m;
  if (needed < reach) return absl::OkStatus();
  return absl::OutOfRangeError(absl::StrCat("The map reaches ", std::ceil(needed),
                                            " m from its origin, an OctoMap of ",
                                            options.resolution_m, " m voxels ends at ",
                                            std::floor(reach), " m: choose a coarser resolution"));
}

absl::Status CastSubmap(const Submap& submap, const Pose& T_map_submap,
                        const OccupancyOptions& options, EvidenceGrid* grid) {
  const Eigen::Matrix3d R = T_map_submap.RotationMatrix();
  std::vector<Eigen::Vector3d> points;
  size_t begin = 0;
  for (size_t k = 0; k < submap.keyframes.size(); ++k) {
    const Eigen::Vector3d origin = T_map_submap * submap.keyframes[k].T_submap_sensor.translation();
    points.clear();
    // Points are grouped by keyframe.
    for (; begin < submap.points.size() && submap.points[begin].keyframe <= k; ++begin) {
      const SubmapPoint& p = submap.points[begin];
      points.push_back(R * p.Position().cast<double>() + T_map_submap.translation());
    }
    if (!origin.allFinite()) continue;
    if (const absl::Status status = CheckReach(origin, options); !status.ok()) return status;
    if (!grid->InsertScan(origin, points)) return TooLargeOctomap(options);
  }
  return absl::OkStatus();
}

struct Source {
  const PlacedSubmap* placed = nullptr;
  uint64_t stamp = 0;
  std::shared_ptr<const std::vector<ColumnKey>> columns;  // Null: not known yet.
  bool is_missing = false;
};

class Updater {
 public:
  Updater(const EvidenceLayer* kept, const SubmapReader& reader, const OccupancyOptions& options)
      : kept_(kept),
        reader_(reader),
        options_(options),
        cut_(options.region, options.resolution_m) {}

  absl::StatusOr<UpdatedLayer> Run(const std::vector<const PlacedSubmap*>& submaps) {
    for (const PlacedSubmap* placed : submaps) sources_.push_back(WhatIsKnownOf(*placed));
    const auto is_new = [](const Source& source) { return source.columns == nullptr; };
    const auto unknown =
        static_cast<size_t>(std::count_if(sources_.begin(), sources_.end(), is_new));
    if (unknown * kNewParts > sources_.size()) kept_ = nullptr;
    absl::Status status;
    // Each time one source less.
    for (is_void_ = true; is_void_ && status.ok();) {
      is_void_ = false;
      done_.clear();
      spent_ = 0;
      if (kept_ != nullptr) status = Plan();
      if (status.ok()) status = CastPlanned();
    }
    if (!status.ok()) return status;
    return Finish();
  }

 private:
  // A column and what is known of it when the first so many sources were gone through.
  struct Evidence {
    uint64_t made_of = 0;
    uint32_t kept_until = 0;  // The kept evidence is that of the sources before this one.
  };

  Source WhatIsKnownOf(const PlacedSubmap& placed) const {
    Source source{&placed, IdentityOf(placed), nullptr};
    if (kept_ == nullptr) return source;
    const auto it = kept_->submaps.find(placed.submap->id);
    if (it == kept_->submaps.end() || it->second.stamp != source.stamp) return source;
    source.columns = it->second.columns;
    return source;
  }

  // Null, and the source is missing from now on, where the reader has it not.
  absl::StatusOr<std::shared_ptr<const Submap>> Read(Source* source) {
    if (options_.region.keep_on != nullptr && !options_.region.keep_on()) {
      return absl::CancelledError("the reader went away");
    }
    std::shared_ptr<const Submap> submap = reader_(source->placed->submap->id);
    if (submap != nullptr) return submap;
    source->is_missing = true;
    // Plans and casts with it are then of other submaps than those there are.
    is_void_ = is_void_ || source->columns != nullptr;
    return submap;
  }

  absl::Status Cast(uint32_t number, EvidenceGrid* grid) {
    Source& source = sources_[number];
    const auto submap = Read(&source);
    if (!submap.ok()) return submap.status();
    if (*submap == nullptr) return absl::OkStatus();
    grid->BeginSubmap(number);
    if (absl::Status status = CastSubmap(**submap, source.placed->T_map_submap, options_, grid);
        !status.ok()) {
      return status;
    }
    if (source.columns == nullptr) {
      source.columns = std::make_shared<const std::vector<ColumnKey>>(grid->Touched());
    }
    return absl::OkStatus();
  }

  absl::flat_hash_map<ColumnKey, Evidence> GoThroughSources() const {
    absl::flat_hash_map<ColumnKey, Evidence> columns;
    for (uint32_t i = 0; i < sources_.size(); ++i) {
      if (sources_[i].is_missing) continue;
      for (const ColumnKey& key : *sources_[i].columns) {
        Evidence& evidence = columns[key];
        evidence.made_of = absl::HashOf(evidence.made_of, sources_[i].stamp);
        const EvidenceLayer::Column* column = Kept(key);
        const bool is_kept = column != nullptr && column->made_of == evidence.made_of;
        if (is_kept) evidence.kept_until = i + 1;
      }
    }
    return columns;
  }

  const EvidenceLayer::Column* Kept(const ColumnKey& key) const {
    if (kept_ == nullptr) return nullptr;
    const auto it = kept_->columns.find(key);
    return it == kept_->columns.end() ? nullptr : &it->second;
  }

  // Carries over what is kept and right, and plans the rest, where anything is kept.
  absl::Status Plan() {
    plans_.emplace();
    EvidenceGrid nowhere(options_, options_.max_bytes,
                         [](const ColumnKey&) { return EvidenceGrid::Plan{kNever}; });
    for (uint32_t i = 0; i < sources_.size(); ++i) {
      if (sources_[i].is_missing || sources_[i].columns != nullptr) continue;
      if (absl::Status status = Cast(i, &nowhere); !status.ok()) return status;
    }
    for (const auto& [key, evidence] : GoThroughSources()) {
      const EvidenceLayer::Column* column = Kept(key);
      if (column != nullptr && column->made_of == evidence.made_of) {
        Keep(key, column->packed);
      } else if (cut_.MayTouch(key)) {
        (*plans_)[key] = {evidence.kept_until, evidence.kept_until > 0 ? column->packed : nullptr};
      }
    }
    return absl::OkStatus();
  }

  EvidenceGrid::Plan PlanOf(const ColumnKey& key) const {
    if (begin_ && key < *begin_) return {kNever};
    if (!plans_) return {cut_.MayTouch(key) ? 0 : kNever};
    const auto it = plans_->find(key);
    return it == plans_->end() ? EvidenceGrid::Plan{kNever} : it->second;
  }

  bool IsToCast(uint32_t number) const {
    const Source& source = sources_[number];
    if (source.is_missing || source.columns == nullptr) return !source.is_missing;
    return std::any_of(source.columns->begin(), source.columns->end(),
                       [&](const ColumnKey& key) { return PlanOf(key).from <= number; });
  }

  // In as many passes as memory takes.
  absl::Status CastPlanned() {
    begin_.reset();
    for (int left = kMostCastings; left > 0 && spent_ < options_.max_bytes; --left) {
      const uint64_t before = updated_.columns_cast;
      EvidenceGrid grid(options_, options_.max_bytes - spent_,
                        [this](const ColumnKey& key) { return PlanOf(key); });
      for (uint32_t i = 0; i < sources_.size() && !is_void_; ++i) {
        if (!IsToCast(i)) continue;
        if (absl::Status status = Cast(i, &grid); !status.ok()) return status;
      }
      if (is_void_) return absl::OkStatus();
      grid.TakeEach([this](const ColumnKey& key, PackedColumn column) {
        Keep(key, std::make_shared<const PackedColumn>(std::move(column)));
        ++updated_.columns_cast;
      });
      if (!grid.end()) return absl::OkStatus();
      if (grid.given_up() / left > updated_.columns_cast - before) break;  // Would be in vain.
      begin_ = grid.end();
    }
    return TooLargeOctomap(options_);
  }

  void Keep(const ColumnKey& key, std::shared_ptr<const PackedColumn> packed) {
    spent_ += packed->bytes();
    done_[key].packed = std::move(packed);
  }

  UpdatedLayer Finish() {
    const auto evidence = GoThroughSources();
    for (auto& [key, column] : done_) column.made_of = evidence.at(key).made_of;
    EvidenceLayer& layer = updated_.layer;
    layer.resolution_m = options_.resolution_m;
    layer.max_range_m = options_.max_range_m;
    layer.robot = options_.robot;
    layer.columns = std::move(done_);
    for (const Source& source : sources_) {
      updated_.missing += source.is_missing;
      if (source.is_missing) continue;
      layer.submaps[source.placed->submap->id] = {source.stamp, source.columns};
    }
    return std::move(updated_);
  }

  static constexpr uint32_t kNever = EvidenceGrid::Plan::kNever;

  const EvidenceLayer* kept_;
  const SubmapReader& reader_;
  const OccupancyOptions& options_;
  const RegionCut cut_;
  std::vector<Source> sources_;
  // Columns to cast; nothing: all in the region.
  std::optional<absl::flat_hash_map<ColumnKey, EvidenceGrid::Plan>> plans_;
  std::optional<ColumnKey> begin_;  // First column of the pass under way.
  bool is_void_ = false;            // A source went away that plans rest on.
  absl::flat_hash_map<ColumnKey, EvidenceLayer::Column> done_;
  uint64_t spent_ = 0;  // Bytes of `done_`.
  UpdatedLayer updated_;
};

}  // namespace

absl::Status TooLargeOctomap(const OccupancyOptions& options) {
  return absl::ResourceExhaustedError(
      absl::StrCat("An OctoMap of ", options.resolution_m, " m voxels and ", options.max_range_m,
                   " m range needs more than ", options.max_bytes >> 20,
                   " MB here: choose a coarser resolution, a shorter range, a region or fewer "
                   "robots"));
}

uint64_t IdentityOf(const PlacedSubmap& placed) {
  const SubmapFingerprint print = FingerprintOf(*placed.submap);
  const Eigen::Vector3d& t = placed.T_map_submap.translation();
  const Eigen::Vector4d q = placed.T_map_submap.rotation().coeffs();
  return absl::HashOf(placed.submap->id.session.value(), placed.submap->id.index,
                      print.first_stamp_ns, print.last_stamp_ns, print.first_sequence,
                      print.last_sequence, print.points, print.keyframes, t.x(), t.y(), t.z(),
                      q.x(), q.y(), q.z(), q.w());
}

absl::StatusOr<UpdatedLayer> UpdateLayer(const EvidenceLayer* kept,
                                         const std::vector<const PlacedSubmap*>& submaps,
                                         const SubmapReader& reader,
                                         const OccupancyOptions& options) {
  return Updater(kept, reader, options).Run(submaps);
}

}  // namespace isthmus::composition
