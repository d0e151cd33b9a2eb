#include "storage/memory_store.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <map>
#include <mutex>
#include <set>
#include <utility>

namespace isthmus::storage {
namespace {

struct StoredSession {
  SessionRecord record;
  std::map<uint64_t, TrajectoryEntry> trajectory;  // By sequence.
  std::map<uint32_t, std::shared_ptr<const Submap>> submaps;
};

class MemoryStore : public MapStore {
 public:
  absl::Status Write(const WriteBatch& batch) override {
    std::lock_guard lock(mutex_);
    if (absl::Status status = Check(batch); !status.ok()) return status;
    for (const SessionRecord& record : batch.sessions) {
      if (!sessions_.contains(record.id)) order_.push_back(record.id);
      sessions_[record.id].record = record;
    }
    for (const auto& [session, entry] : batch.trajectory) {
      sessions_[session].trajectory.emplace(entry.sequence, entry);
    }
    for (const auto& submap : batch.submaps) {
      sessions_[submap->id.session].submaps[submap->id.index] = submap;
    }
    for (const Match& match : batch.matches) matches_[{match.a, match.b}] = match;
    if (batch.revision) revision_ = *batch.revision;
    return absl::OkStatus();
  }

  absl::Status DeleteSession(const SessionId& session) override {
    std::lock_guard lock(mutex_);
    if (sessions_.erase(session) == 0) return Unknown(session);
    std::erase(order_, session);
    std::erase_if(matches_, [&](const auto& item) {
      return item.first.first == session || item.first.second == session;
    });
    std::erase_if(features_,
                  [&](const auto& item) { return item.first.first.session == session; });
    return absl::OkStatus();
  }

  absl::StatusOr<SessionRecord> GetSession(const SessionId& session) const override {
    std::lock_guard lock(mutex_);
    const auto it = sessions_.find(session);
    if (it == sessions_.end()) return Unknown(session);
    return it->second.record;
  }

  absl::StatusOr<std::vector<SessionRecord>> ListSessions() const override {
    std::lock_guard lock(mutex_);
    std::vector<SessionRecord> records;
    for (const SessionId& id : order_) records.push_back(sessions_.at(id).record);
    std::stable_sort(records.begin(), records.end(), [](const auto& a, const auto& b) {
      return a.created_ns < b.created_ns;
    });
    return records;
  }

  absl::StatusOr<std::vector<TrajectoryEntry>> GetTrajectory(
      const SessionId& session) const override {
    std::lock_guard lock(mutex_);
    const auto it = sessions_.find(session);
    if (it == sessions_.end()) return Unknown(session);
    std::vector<TrajectoryEntry> entries;
    for (const auto& [sequence, entry] : it->second.trajectory) entries.push_back(entry);
    return entries;
  }

  absl::StatusOr<std::shared_ptr<const Submap>> GetSubmap(const SubmapId& id) const override {
    std::lock_guard lock(mutex_);
    const std::shared_ptr<const Submap> submap = Find(id);
    if (submap == nullptr) return absl::NotFoundError(absl::StrCat("no submap ", ToString(id)));
    return submap;
  }

  absl::StatusOr<std::vector<SubmapInfo>> ListSubmaps(
      const std::optional<SessionId>& session) const override {
    std::lock_guard lock(mutex_);
    if (session && !sessions_.contains(*session)) return Unknown(*session);
    std::vector<SubmapInfo> infos;
    for (const auto& [id, stored] : sessions_) {
      if (session && id != *session) continue;
      for (const auto& [index, submap] : stored.submaps) infos.push_back(Summarize(*submap));
    }
    return infos;
  }

  absl::StatusOr<std::vector<SubmapInfo>> FindSubmaps(const SessionId& session,
                                                      const Box& box_odom) const override {
    absl::StatusOr<std::vector<SubmapInfo>> infos = ListSubmaps(session);
    if (!infos.ok()) return infos.status();
    std::erase_if(*infos, [&](const SubmapInfo& info) {
      return !Transform(info.T_odom_submap, info.bounds).Intersects(box_odom);
    });
    return infos;
  }

  absl::StatusOr<std::vector<Match>> ListMatches() const override {
    std::lock_guard lock(mutex_);
    std::vector<Match> matches;
    for (const auto& [pair, match] : matches_) matches.push_back(match);
    return matches;
  }

  absl::StatusOr<MapRevision> LatestRevision() const override {
    std::lock_guard lock(mutex_);
    return revision_;
  }

  absl::Status PutFeatures(const FeatureBlob& blob) override {
    std::lock_guard lock(mutex_);
    if (Find(blob.submap) == nullptr) {
      return absl::FailedPreconditionError(
          absl::StrCat("features of submap ", ToString(blob.submap), ", which is not stored"));
    }
    features_[{blob.submap, blob.kind}] = blob.data;
    return absl::OkStatus();
  }

  absl::StatusOr<std::string> GetFeatures(const SubmapId& submap,
                                          const std::string& kind) const override {
    std::lock_guard lock(mutex_);
    const auto it = features_.find({submap, kind});
    if (it == features_.end()) {
      return absl::NotFoundError(
          absl::StrCat("no features \"", kind, "\" of submap ", ToString(submap)));
    }
    return it->second;
  }

 private:
  static absl::Status Unknown(const SessionId& session) {
    return absl::NotFoundError(absl::StrCat("no session ", session.value()));
  }

  // mutex_ is held for these.
  std::shared_ptr<const Submap> Find(const SubmapId& id) const {
    const auto session = sessions_.find(id.session);
    if (session == sessions_.end()) return nullptr;
    const auto submap = session->second.submaps.find(id.index);
    return submap == session->second.submaps.end() ? nullptr : submap->second;
  }

  // Everything that could make a batch fail, so that it happens as a whole or not at all.
  absl::Status Check(const WriteBatch& batch) const {
    std::set<SessionId> known;
    for (const SessionRecord& record : batch.sessions) known.insert(record.id);
    const auto require = [&](const SessionId& session) {
      if (sessions_.contains(session) || known.contains(session)) return absl::OkStatus();
      return absl::FailedPreconditionError(absl::StrCat("no session ", session.value()));
    };
    for (const auto& [session, entry] : batch.trajectory) {
      if (absl::Status status = require(session); !status.ok()) return status;
    }
    std::set<SubmapId> added;
    for (const auto& submap : batch.submaps) {
      if (absl::Status status = require(submap->id.session); !status.ok()) return status;
      if (Find(submap->id) != nullptr || !added.insert(submap->id).second) {
        return absl::AlreadyExistsError(absl::StrCat("submap ", ToString(submap->id), " exists"));
      }
    }
    for (const Match& match : batch.matches) {
      if (absl::Status status = require(match.a); !status.ok()) return status;
      if (absl::Status status = require(match.b); !status.ok()) return status;
    }
    if (batch.revision && batch.revision->revision <= revision_.revision) {
      return absl::FailedPreconditionError(absl::StrCat("revision ", batch.revision->revision,
                                                        " is not newer than ",
                                                        revision_.revision));
    }
    return absl::OkStatus();
  }

  mutable std::mutex mutex_;
  std::map<SessionId, StoredSession> sessions_;  // Guarded by mutex_, as is all below.
  std::vector<SessionId> order_;                 // Of creation.
  std::map<std::pair<SessionId, SessionId>, Match> matches_;
  std::map<std::pair<SubmapId, std::string>, std::string> features_;
  MapRevision revision_;
};

}  // namespace

std::unique_ptr<MapStore> MakeMemoryStore() { return std::make_unique<MemoryStore>(); }

}  // namespace isthmus::storage
