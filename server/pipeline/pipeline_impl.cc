#include "server/pipeline/pipeline_impl.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <utility>

namespace isthmus::server {

absl::StatusOr<std::unique_ptr<Pipeline>> Pipeline::Open(const PipelineOptions& options,
                                                         std::unique_ptr<storage::MapStore> store,
                                                         const Clock& clock) {
  auto pipeline = std::make_unique<PipelineImpl>(options, std::move(store), clock);
  if (absl::Status status = pipeline->Start(); !status.ok()) return status;
  return pipeline;
}

PipelineImpl::PipelineImpl(const PipelineOptions& options, std::unique_ptr<storage::MapStore> store,
                           const Clock& clock)
    : options_(options),
      clock_(clock),
      health_(&clock, options.on_problem),
      store_(WatchStore(std::move(store), &health_)),
      submaps_(store_.get(), options.submap_cache_bytes,
               [this](const SubmapId& id, const std::string& problem) { NoteDamage(id, problem); }),
      state_(store_.get(), &submaps_, &clock) {}

PipelineImpl::~PipelineImpl() { Shutdown(); }

absl::Status PipelineImpl::Start() {
  if (absl::Status status = state_.Load(); !status.ok()) return status;
  auto scans = ScanKeeper::Open(options_.archive, options_.on_problem);
  if (!scans.ok()) return scans.status();
  scans_ = *std::move(scans);
  retention_ = std::make_unique<RetentionLoop>(options_.retention, &clock_, RetentionHooks());
  executor_ = std::make_unique<Executor>(options_.ingest_threads);
  for (auto& [id, entry] : state_.sessions) {
    if (entry.record.state == SessionState::kFinished || entry.record.segment > 1) continue;
    auto worker = ResumeWorker(entry);
    if (!worker.ok()) return worker.status();
    entry.worker = *std::move(worker);
  }
  placement_ = std::make_unique<PlacementLoop>(&state_, store_.get(), &clock_, options_.placer);
  state_.WaitUntilPlaced();
  compositor_ = std::make_unique<Compositor>(
      &state_, [this](const SubmapId& id) { return submaps_.Get(id); }, options_.composer,
      options_.composition_interval_s, options_.on_problem);
  estimator_ = std::make_unique<Estimator>(
      &state_, store_.get(), &submaps_, &clock_,
      Estimator::Options{options_.matcher, options_.loops, options_.revisits,
                         options_.rematch_submaps, options_.prepared_bytes,
                         options_.work_journal, options_.on_problem});
  retention_->Start();
  store_retries_ = std::thread([this] { RunStoreRetries(); });
  return absl::OkStatus();
}

absl::StatusOr<std::shared_ptr<ingest::SessionWorker>> PipelineImpl::ResumeWorker(
    const SessionEntry& entry) {
  ingest::ResumePoint resume;
  resume.checkpoint = ReadCheckpoint(entry.record.id);
  for (const SessionEntry* segment : state_.SegmentsOf(entry.record.id)) {
    absl::StatusOr<ingest::StoredSegment> stored = ReadSegment(*segment);
    if (!stored.ok()) return stored.status();
    resume.segments.push_back(*std::move(stored));
  }
  auto worker = MakeWorker(entry.record, resume);
  if (!worker.ok() || !options_.on_problem) return worker;
  if (const std::string resumed = (*worker)->Status().resumed; !resumed.empty()) {
    options_.on_problem(absl::StrCat("session ", entry.record.id.value(), " was ", resumed,
                                     "; it does not go on exactly as it was"));
  }
  return worker;
}

absl::StatusOr<ingest::StoredSegment> PipelineImpl::ReadSegment(const SessionEntry& entry) {
  absl::StatusOr<std::vector<TrajectoryEntry>> trajectory = store_->GetTrajectory(entry.record.id);
  if (!trajectory.ok()) return trajectory.status();
  ingest::StoredSegment stored;
  stored.segment = entry.record.segment;
  stored.trajectory = *std::move(trajectory);
  stored.next_index = entry.next_index();
  if (!entry.submaps.empty()) stored.last_sequence = entry.submaps.back()->last_sequence;
  stored.for_each_submap = [this, &entry](const std::function<void(const Submap&)>& visit) {
    for (const auto& submap : entry.submaps) {
      if (const auto whole = submaps_.Get(submap->id)) visit(*whole);
    }
  };
  return stored;
}

std::optional<ingest::Checkpoint> PipelineImpl::ReadCheckpoint(const SessionId& session) {
  absl::StatusOr<storage::Checkpoint> stored = store_->GetCheckpoint(session);
  if (absl::IsNotFound(stored.status())) return std::nullopt;
  if (!stored.ok()) return ingest::Checkpoint();  // Damaged: the worker goes on from the submaps.
  return ingest::Checkpoint{stored->sequence, stored->durable_sequence, std::move(stored->data)};
}

void PipelineImpl::NoteDamage(const SubmapId& submap, const std::string& problem) {
  {
    std::lock_guard lock(state_.mutex);
    state_.damaged[submap] = problem;
  }
  if (options_.on_problem) options_.on_problem(problem);
}

SessionStatus PipelineImpl::StatusOf(const SessionEntry& entry) const {
  SessionStatus status;
  status.record = entry.record;
  status.submap_count = static_cast<uint32_t>(entry.submaps.size());
  status.point_count = entry.points;
  if (const Placement* placement = state_.PlacementOf(entry.record.id)) {
    status.placement = *placement;
  }
  status.quota_bytes = options_.retention.LimitsOf(entry.record.robot).quota_bytes;
  if (entry.record.segment == 1) {
    FillStreamStatus(entry, &status);
  } else if (!entry.submaps.empty()) {
    status.last_sequence = status.durable_sequence = entry.submaps.back()->last_sequence;
  }
  return status;
}

void PipelineImpl::FillStreamStatus(const SessionEntry& entry, SessionStatus* status) const {
  const ingest::WorkerStatus worker =
      entry.worker != nullptr ? entry.worker->Status() : entry.final_status;
  status->last_sequence = worker.last_sequence;
  status->durable_sequence = worker.durable_sequence;
  status->scans_processed = worker.processed;
  status->scans_rejected = worker.rejected;
  status->odometry_ms_mean = worker.odometry_ms_mean;
  status->travelled_m = worker.travelled_m;
  status->tracking = worker.tracking;
  status->input = worker.input;
  status->scans = entry.worker != nullptr ? worker.scans : entry.record.scans;
  status->lost_since_ns = worker.lost_since_ns;
  const std::vector<const SessionEntry*> segments = state_.SegmentsOf(entry.record.id);
  status->segments = std::max(worker.segment, segments.back()->record.segment);
  for (const SessionEntry* segment : segments) {
    if (entry.worker != nullptr || entry.uploads || segment->submaps.empty()) continue;
    const uint64_t stored = segment->submaps.back()->last_sequence;
    status->last_sequence = std::max(status->last_sequence, stored);
    status->durable_sequence = std::max(status->durable_sequence, stored);
  }
  status->map_bytes = retention_->MapBytes(entry.record.id);
  status->scan_bytes = scans_->Bytes(entry.record.id);
  status->archive_problem = scans_->Problem(entry.record.id);
}

bool PipelineImpl::IsSettled() const {
  return state_.pending_scans == 0 && state_.IsPlaced() && state_.IsComposed() &&
         estimator_->IsUpToDate();
}

void PipelineImpl::WaitUntilIdle() {
  retention_->WaitUntilIdle();
  std::unique_lock lock(state_.mutex);
  state_.changed.wait(lock, [this] { return shut_down_ || IsSettled(); });
}

void PipelineImpl::Shutdown() {
  if (shut_down_.exchange(true)) return;
  if (executor_ == nullptr) return;  // Never started.
  health_.Stop();
  if (store_retries_.joinable()) store_retries_.join();
  if (retention_ != nullptr) retention_->Stop();
  if (estimator_ != nullptr) estimator_->Stop();
  std::vector<std::shared_ptr<ingest::SessionWorker>> workers;
  {
    std::lock_guard lock(state_.mutex);
    for (auto& [id, entry] : state_.sessions) {
      if (entry.worker != nullptr) workers.push_back(entry.worker);
    }
    state_.changed.notify_all();
  }
  // A session whose last submap cannot be stored resumes from the one before: its robot was never
  // told that more is durable.
  for (const auto& worker : workers) (void)worker->Finish();
  if (placement_ != nullptr) placement_->Stop();
  if (compositor_ != nullptr) compositor_->Stop();
}

}  // namespace isthmus::server
