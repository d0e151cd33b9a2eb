// The runner of jobs, in the server and in workers: the one way to match maps, to compare plans and
// to search for loops.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <map>
#include <memory>
#include <stop_token>
#include <string>

#include "core/lru_cache.h"
#include "server/jobs/await_store.h"
#include "server/jobs/job.h"
#include "server/jobs/prepared_maps.h"
#include "server/jobs/prepared_store.h"
#include "server/map/submap_cache.h"
#include "server/matching/index/session_plan.h"
#include "server/matching/loops/loop_finder.h"
#include "server/matching/pairs/matcher.h"
#include "storage/map_store.h"

namespace isthmus::server {

// Maps and plans stay ready from one job to the next that has them. Not thread safe.
class JobRunner {
 public:
  struct Options {
    size_t submap_cache_bytes = size_t{64} << 20;
    // Maps kept ready may take so much, without the two at hand.
    size_t prepared_bytes = size_t{128} << 20;
    // Read by this one; null: by one of its own, of `submap_cache_bytes`.
    SubmapCache* submaps = nullptr;
    // Submaps for which there is no sense in waiting are left out of the job, all but the first at
    // once. Null: the job fails.
    WaitForStore wait = nullptr;
  };

  JobRunner(storage::MapStore* store, const Options& options);

  // The match, of the same job always the same but for the times of its stages. Cancelled once
  // `stop` is requested; FailedPrecondition where submaps of it are not in the store any more, as
  // they were retired since, or are damaged; Unavailable where the store failed otherwise, of which
  // the job is innocent. May throw what matching throws.
  absl::StatusOr<PairResult> Run(const PairJob& job, std::stop_token stop);
  // The same for other jobs, without times. A search for loops goes on without submaps that are
  // damaged, and without older ones that are gone.
  absl::StatusOr<PlanScores> Run(const PlanJob& job, std::stop_token stop);
  absl::StatusOr<LoopResult> Run(const LoopJob& job, std::stop_token stop);
  absl::StatusOr<JobResult> Run(const Job& job, std::stop_token stop);
  // The same as bytes.
  absl::StatusOr<std::string> Run(const std::string& job, std::stop_token stop);

  // True if the last job was done without a submap that the store did not give.
  bool has_left_out() const { return has_left_out_; }

  uint64_t prepared_bytes() const { return prepared_.bytes(); }  // Bytes of maps kept ready.

  // Lets go of all that is kept of sessions for which `goes` is true.
  template <typename Predicate>
  void ForgetIf(const Predicate& goes) {
    prepared_.ForgetIf(goes);
    maps_.EraseIf(goes);
    plans_.EraseIf(goes);
    finders_.EraseIf(goes);
  }

 private:
  struct Kept {
    std::string bytes;  // EncodeMap of its source.
    ShapedMap map;
  };
  struct KeptFinder {
    matching::LoopOptions options;
    std::map<uint32_t, int64_t> stamps_ns;  // Stamps of the submaps that it may know, by index.
    std::unique_ptr<matching::LoopFinder> finder;
  };
  struct KeptPlan {
    JobMapInput map;  // Its source.
    std::shared_ptr<const matching::SessionPlan> plan;
  };
  // Null where submaps are missing.
  std::shared_ptr<const Kept> MapOf(const JobMapInput& map);
  std::shared_ptr<const KeptPlan> PlanOf(const JobMapInput& map);
  // One that knows no other submaps under the ids of these.
  matching::LoopFinder& FinderOf(const LoopJob& job);
  // Null where it cannot be read. All that read throw StoreFailed.
  std::shared_ptr<const Submap> PointsOf(const SubmapId& id);
  // NotFound where it is gone or not the one that is meant, DataLoss where it is damaged,
  // Unavailable where it is left out.
  absl::StatusOr<std::shared_ptr<const Submap>> OutlineOf(const JobMapInput& map, size_t k);
  std::shared_ptr<const matching::PreparedSubmap> GetPrepared(
      const std::shared_ptr<const Submap>& outline);

  struct StoreFailed {
    absl::Status status;
  };
  // The result of `read`, once the store is not away.
  template <typename Read>
  auto Await(const Read& read) -> decltype(read());
  // The result of work that may be stopped or fail so.
  template <typename T, typename Work>
  absl::StatusOr<T> Guard(const Work& work);

  const WaitForStore wait_;
  const std::unique_ptr<SubmapCache> own_submaps_;  // Null where it was given one.
  SubmapCache* const submaps_;
  const PreparedStore prepared_store_;
  PreparedMaps prepared_;
  std::stop_token stop_;
  bool has_left_out_ = false;
  // As of the latest jobs.
  LruCache<SessionId, std::shared_ptr<const Kept>> maps_;
  LruCache<SessionId, std::shared_ptr<const KeptPlan>> plans_;
  LruCache<SessionId, std::shared_ptr<KeptFinder>> finders_;
};

}  // namespace isthmus::server
