// The slow loop: a thread that finds where sessions came back to, how two sessions' maps lie to
// each other, and which submaps have been seen again often enough. Nobody waits for it. Where
// there are workers these match, compare and, where it falls behind, search, by the board of the
// store.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/clock.h"
#include "core/records/server_load.h"
#include "core/stopwatch.h"
#include "server/jobs/job_key.h"
#include "server/jobs/job_runner.h"
#include "server/jobs/limits.h"
#include "server/jobs/prepared_maps.h"
#include "server/jobs/prepared_store.h"
#include "server/map/map_writer.h"
#include "server/matching/index/place_index.h"
#include "server/matching/loops/revisits.h"
#include "server/matching/pairs/matcher.h"
#include "server/threads/limits.h"
#include "server/threads/placed_sessions.h"
#include "server/threads/session_shapes.h"
#include "server/threads/work_journal.h"

namespace isthmus::server {

inline bool IsFinished(const SessionView& session) {
  return session.record.state == SessionState::kFinished;
}

// Has enough points for any match; see kLeastMatchedPoints.
inline bool IsMatchable(const SessionView& session) {
  return !session.submaps.empty() && session.points >= kLeastMatchedPoints;
}

class MatchingThread {
 public:
  struct Options {
    matching::MatcherOptions matcher;
    matching::LoopOptions loops;
    matching::RevisitOptions revisits;
    // A pair is tried again when its maps have grown by this many submaps; a finished session's
    // last submaps always count.
    int rematch_submaps = 1;
    // The memory that maps kept ready may take, without the two at hand.
    size_t prepared_bytes = size_t{128} << 20;
    // See WorkJournal; empty: none.
    std::string work_journal;
    // Told, from the thread, what was left out and why. May be null.
    std::function<void(const std::string& problem)> on_problem;
  };

  MatchingThread(MapWriter* map, Activity* activity, storage::MapStore* store, SubmapCache* submaps,
                 const Clock* clock, const Options& options);
  ~MatchingThread();  // Stops.

  // True if the view shows nothing that it has not dealt with.
  bool IsUpToDateWith(const MapView& view) const { return up_to_date_with_ == view.serial; }

  MatchingLoad Load(const MapView& view) const {
    return {IsUpToDateWith(view), waiting_submaps_, waiting_pairs_, workers_,
            posted_count_,        set_aside_count_};
  }
  uint64_t prepared_bytes() const { return prepared_bytes_; }  // Of maps kept ready.

  // Makes the thread end within a second or so; does not wait. What is under way is given up, to be
  // taken up at the next start.
  void Stop();

 private:
  // The state in which a pair was last tried: the indices that their next submaps had.
  struct Attempt {
    uint32_t next_a = 0, next_b = 0;
    uint32_t shape_a = 0, shape_b = 0;  // SessionShapes::version.
    uint64_t anchors = 0;               // KnownAnchors::Version.
  };
  // That by which a match was computed.
  static Attempt AttemptOf(const MapView& view, const SessionView& a, const SessionView& b,
                           uint32_t submaps_a, uint32_t submaps_b, int64_t computed_ns);

  // What a pair is tried for.
  struct Occasion {
    bool last_submaps = false;  // No more will come.
    bool first_look = false;    // Of many, whether it is worth a search.
  };
  // Thrown through the matcher once the thread is to end.
  struct Stopped {};

  void Run();
  // The task that comes first; false when all is up to date.
  bool RunNext(const MapView& view);

  // Does work that no record may keep from being followed by other work: what throws, or ended the
  // server before, is told and left out. False where it was not done.
  bool RunGuarded(const JobKey& key, const std::function<void()>& work);
  bool IsLeftOut(const JobKey& key) const;
  // What was left out for long enough.
  void TryLeftOutAgain();
  // True the first time that this work is told of.
  bool TellLeftOut(const JobKey& key, const std::string& problem);
  // Of the board, each sentence once. Trouble with the way to it others tell.
  void TellOfBoard(const std::string& what, const absl::Status& status);
  // Of a submap that cannot be read one without a surface. As the next one throws Stopped.
  std::shared_ptr<const matching::PreparedSubmap> GetPrepared(
      const std::shared_ptr<const Submap>& outline) const;
  // Null where it cannot be read.
  std::shared_ptr<const Submap> OutlineOf(const SubmapId& submap) const;
  // What is read once the store is not away, so that nothing is matched with a part of a map.
  template <typename Read>
  auto Await(const Read& read) const -> decltype(read());
  // Waits a moment for the store, in vain asked `since`; false where there is no sense in it.
  bool AwaitStore(const Stopwatch& since) const;
  void LookAgainSoon() const;
  // Throws what `write` fails with; only once the store is back, and has room again.
  void AwaitStored(const std::function<absl::Status()>& write) const;

  // The first submap that was not asked for loops yet; only once it is placed, and nobody is at
  // the one before.
  std::optional<SubmapId> NextForLoops(const MapView& view) const;
  // All of those.
  uint64_t CountForLoops(const MapView& view) const;
  void FindLoops(const MapView& view, const SubmapId& submap);
  // What is stored of how far a session was searched, so that a server that starts goes on there.
  static std::vector<SubmapId> NewestFirst(const SessionView& session);
  uint32_t FirstUnsearched(const SessionView& session) const;
  void StoreSearched(const SubmapId& submap) const;
  // The job has those submaps up to this one that can be read; reads from the store.
  LoopJob MakeLoopJob(const MapView& view, const SubmapId& submap, const SessionView& session,
                      const Placement& placement) const;

  // Of one session: they are searched before any others.
  static bool AreSegments(const SessionView& a, const SessionView& b);
  // With few sessions all pairs are searched.
  static bool SelectsPartners(const MapView& view);
  // A session that is to be compared with all others: it is new, or has grown by a good part.
  std::optional<SessionId> NextToIndex(const MapView& view) const;
  void IndexSession(const MapView& view, const SessionId& id);
  // With the sessions that were compared before.
  PlanJob MakePlanJob(const MapView& view, const SessionView& session);
  // Pairs of a session that were tried: all, those that were searched, beyond a first look, and
  // those within a component.
  struct Tried {
    size_t pairs = 0, searched = 0, joined = 0;
  };
  // How many pairs of a session may be tried, as of when it had so many submaps.
  struct Allowance {
    Tried up_to;
    uint32_t next_index = 0;
    bool HasRoom(const Tried& tried) const {
      return tried.pairs < up_to.pairs && tried.searched < up_to.searched;
    }
    // For those beside it: however many strangers were tried.
    bool HasRoomNear(const Tried& tried) const { return tried.joined < up_to.joined; }
  };
  // Of each session.
  std::map<SessionId, Tried> CountTried(const MapView& view, const PlacedSessions& placed) const;
  // Now that the session's scores are there.
  void ChoosePartners(const MapView& view, const SessionId& session);
  // As they were chosen before the start.
  void RestorePartners(const MapView& view);
  std::optional<Allowance> FindChosen(const SessionView& session) const;
  // Pairs that a server before ended at, which had been chosen.
  std::vector<SessionPair> PairsEndedAt(const MapView& view) const;
  // The likeliest pair that was never tried: what the server before was at, and what is known to be
  // near each other first; then, as long as either has not had its partners, what the index
  // promises most and is not joined yet, of those at hand where there are any; what is joined and
  // lies near each other; and what else the index promises.
  std::optional<SessionPair> NextPartners(const MapView& view) const;
  // One of the last pair: making its map ready would take longer than a first look at it.
  bool IsAtHand(const SessionId& session) const;
  // Segments of one session, and neighbours by anchors.
  static std::optional<SessionPair> NextKnownPartners(
      const MapView& view, const PlacedSessions& placed,
      const std::function<bool(const SessionPair&)>& is_new);

  // The pair to be tried next, if partners are selected likely ones before those tried before; of
  // these, or of all, the one with the most new evidence. Nothing when all is up to date.
  std::optional<SessionPair> NextPair(const MapView& view);
  // The number of new submaps that the pair has since it was tried, and one for each map that its
  // loops have moved; 0 where it is not worth a try.
  uint32_t FreshSubmaps(const MapView& view, const SessionView& a, const SessionView& b,
                        const Attempt& tried) const;
  void EstimateMatch(const MapView& view, const SessionPair& pair);
  // `older` is null where nothing is known of the pair.
  PairJob MakePairJob(const ShapedMap& a, const ShapedMap& b, std::vector<Anchor> anchors,
                      const Occasion& occasion, const Match* older) const;
  // The last word on a pair that is still open takes all there is.
  static bool MustSearch(const Occasion& occasion, const Match* older);
  // Into the map, unless what is known is better.
  absl::Status TakeMatch(const Match& match, const Match* older);

  // --- what workers do (matching_jobs.cc) ---

  bool IsPosted(const JobKey& key) const { return posted_.contains(key); }
  // Jobs that an earlier server of the site has left on the board.
  void AdoptJobs(const MapView& view);
  // Does the job here; what it reads it waits for while the store is away. Throws Stopped, or
  // StatusError where nothing comes of it.
  template <typename Result, typename Made>
  Result RunHere(const Made& job);
  // The server's own search falls behind, and workers come to it.
  bool WantsHelpWithLoops() const;
  void Post(const JobKey& key, std::string payload, bool is_urgent = false);
  // Workers end with it: it is left out until its row is taken off the board.
  void SetAside(const JobKey& key, const std::string& problem);
  bool IsSetAside(const JobKey& key) const { return set_aside_.contains(key); }
  // Looks, now and then, whether there are workers and what they have done.
  void FollowWorkers(const MapView& view);
  void TakeResults(const MapView& view);
  absl::Status TakeResult(const MapView& view, const JobKey& key, const storage::EndedJob& job);
  // `status` is what became of taking it.
  void FinishJob(const JobKey& key, const storage::EndedJob& job, const absl::Status& status);
  absl::Status TakeMatchOf(const MapView& view, const SessionPair& pair, const std::string& result);
  void TakeScores(const SessionId& session, const PlanScores& scores);
  absl::Status TakeLoops(const SubmapId& submap, const LoopResult& result);
  // The job on the board; nothing where it is damaged, or of submaps that are not there: those of a
  // deleted session, whose id may be another's by now.
  static std::optional<Job> ReadJob(const MapView& view, const storage::BoardJob& job);
  // A session of it was deleted.
  static bool IsGone(const MapView& view, const JobKey& key);
  // As if it had never been tried.
  void Forget(const JobKey& key);
  void CountWorkers();
  // Jobs that somebody has taken off the board, or that went with the database's last moments.
  void ForgetMissing();
  // Searches for loops that workers, at pairs meanwhile, do not come to.
  void TakeBackLoops();
  // Jobs of deleted sessions.
  void RemoveGone(const MapView& view);
  // There is nobody to do them.
  void WithdrawJobs();
  bool HasRoomForJobs() const { return posted_.size() < kMaxPostedJobs; }

  void UpdateShapes(const MapView& view);
  // Outlines of those that can be read; reads from the store.
  ShapedMap MapOf(const MapView& view, const SessionView& session);

  // The map shows more submaps than when revisits were counted last.
  bool MustCountRevisits(const MapView& view) const;
  void CountRevisits(const MapView& view);

  // The new evidence of a pair that was tried so, or never (an empty attempt); 0: no reason to try.
  uint32_t Evidence(const MapView& view, const SessionView& a, const SessionView& b,
                    const Attempt& tried, uint64_t anchors) const;

  // Forgets what was kept of sessions that are gone.
  void ForgetGone(const MapView& view);

  MapWriter* const map_;
  Activity* const activity_;
  storage::MapStore* const store_;
  SubmapCache* const submaps_;
  const PreparedStore prepared_store_;
  storage::JobBoard* const board_;  // Null: there are no workers.
  const Clock* const clock_;
  const int64_t started_ns_;
  std::stop_source stop_;
  const Options options_;
  mutable WorkJournal journal_;
  // The serial of the last view that left nothing to do; of no view at first.
  std::atomic<uint64_t> up_to_date_with_ = ~uint64_t{0};
  // Set by the thread, told by Load.
  std::atomic<uint64_t> waiting_submaps_ = 0, waiting_pairs_ = 0, prepared_bytes_ = 0;
  std::atomic<uint64_t> workers_ = 0, posted_count_ = 0, set_aside_count_ = 0;
  // Touched by the thread only, once it runs.
  std::map<SessionPair, Attempt> attempts_;  // Since the start, whatever came of them.
  std::optional<SessionPair> last_pair_;     // Of these.
  std::map<SessionId, uint32_t> looped_;     // The next submap to ask.
  // Of which submaps were left out: what was searched behind these is, after the next start, again.
  std::set<SessionId> has_gaps_;
  int64_t counted_revision_ = -1;
  JobRunner runner_;
  std::map<SessionId, uint32_t> indexed_;  // The next submap when it was compared with others.
  std::map<SessionId, Allowance> allowed_;
  std::vector<SessionPair> unfinished_;  // PairsEndedAt at the start.
  matching::PlaceIndex index_;
  std::vector<matching::RankedPair> ranked_;  // By the index, as of its last change.
  std::map<SessionPair, matching::PairMemory> pair_memories_;
  std::map<SessionId, matching::LoopMemory> memories_;  // Of searches for loops.
  SessionShapes shapes_;
  matching::RevisitCounter revisits_;
  std::set<JobKey> left_out_;           // Told already.
  std::set<std::string> told_;          // Problems of the board.
  std::set<JobKey> ended_at_;           // Left out, as the journal says that servers ended at it.
  std::map<JobKey, Stopwatch> posted_;  // On the board, since then.
  std::set<JobKey> set_aside_;          // On the board too.
  bool has_workers_ = false, told_of_other_versions_ = false;
  std::optional<Stopwatch> looked_for_workers_, looked_for_results_, took_loops_back_;
  std::thread thread_;
};

}  // namespace isthmus::server
