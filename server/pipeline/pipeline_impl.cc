#include "server/pipeline/pipeline_impl.h"

#include <algorithm>
#include <thread>

#include "core/caught.h"
#include "core/paper.h"

namespace isthmus::server {

namespace {

// They pack submaps and wait for the disk. With two a large one does not hold up the others.
constexpr int kStoringThreads = 2;

}  // namespace

int IngestThreads(int setting) {
  if (setting > 0) return setting;
  return static_cast<int>(std::max(4u, 2 * std::thread::hardware_concurrency()));
}

absl::StatusOr<std::unique_ptr<Pipeline>> Pipeline::Open(const PipelineOptions& options,
                                                         std::unique_ptr<storage::MapStore> store,
                                                         const Clock& clock) {
  try {
    auto pipeline = std::make_unique<PipelineImpl>(options, std::move(store), clock);
    if (absl::Status status = pipeline->Start(); !status.ok()) return status;
    return pipeline;
  } catch (...) {
    return CaughtStatus();
  }
}

PipelineImpl::PipelineImpl(const PipelineOptions& options, std::unique_ptr<storage::MapStore> store,
                           const Clock& clock)
    : ReadingPipeline(options, std::move(store), clock) {}

PipelineImpl::~PipelineImpl() {
  Shutdown();
  // Workers' last tasks, before the objects that they use.
  localisation_maps_ = nullptr;
  executor_ = nullptr;
}

absl::Status PipelineImpl::Start() {
  if (!kHasPaper && parts_.options.matcher.search == matching::SearchMode::kPaper) {
    return absl::InvalidArgumentError(
        "this program was built without the paper's matching chain (ISTHMUS_PAPER=OFF): search by "
        "\"default\" or \"birds_eye\"");
  }
  if (absl::Status status = parts_.map.Load(parts_.options.on_problem); !status.ok()) return status;
  parts_.events.Start();
  absl::Status status = OpenParts([this](const ingest::RetentionAction& action) {
    if (action.kind == ingest::RetentionAction::Kind::kDropScans) {
      return parts_.scans->FreeBytes(action.session, action.bytes);
    }
    return sessions_.Remove(action.session, action.why, {});
  });
  if (!status.ok()) return status;
  storing_ =
      std::make_unique<Executor>(Executor::Options{.threads = kStoringThreads, .name = "storing"});
  parts_.storing = storing_.get();
  if (status = sessions_.Resume(); !status.ok()) return status;
  StartPlacing(parts_.store.get());
  MapWriter* const map = &parts_.map;
  map->WaitUntilPlaced();
  StartComposing();
  const PipelineOptions& options = parts_.options;
  matching_ = std::make_unique<MatchingThread>(
      map, &parts_.activity, parts_.store.get(), &parts_.submaps, &parts_.clock,
      MatchingThread::Options{options.matcher, options.loops, options.revisits,
                              options.rematch_submaps, options.prepared_bytes,
                              options.crash_journal, options.on_problem});
  retention_->Start();
  store_retries_ = std::make_unique<StoreRetryThread>(&parts_.health, &parts_.workers, map,
                                                      parts_.store.get(), &parts_.membership);
  return absl::OkStatus();
}

bool PipelineImpl::IsSettled(uint64_t pending_scans, const MapView& view) const {
  return ReadingPipeline::IsSettled(pending_scans, view) && matching_->IsUpToDateWith(view);
}

void PipelineImpl::WaitUntilIdle() {
  retention_->WaitUntilIdle();
  WaitUntilSettled();
  if (!parts_.shut_down) parts_.events.WaitUntilStored();
}

void PipelineImpl::StopTaking() {
  for (const auto& worker : parts_.workers.All()) worker->StopTaking();
}

void PipelineImpl::Shutdown() {
  if (parts_.shut_down.exchange(true)) return;
  if (executor_ == nullptr) return parts_.events.Stop();  // Never started.
  store_retries_ = nullptr;
  if (retention_ != nullptr) retention_->Stop();
  if (matching_ != nullptr) matching_->Stop();
  parts_.activity.changed().Notify();
  // A session whose last submap cannot be stored resumes from the one before: its robot was never
  // told that more is durable.
  for (const auto& worker : parts_.workers.All()) (void)worker->Finish();
  if (placement_ != nullptr) placement_->Stop();
  if (composition_ != nullptr) composition_->Stop();
  parts_.events.Stop();
}

}  // namespace isthmus::server
