// Resuming of a session where its last worker ended.
#include <absl/strings/str_cat.h>

#include <algorithm>
#include <utility>

#include "server/ingest/session_worker.h"

namespace isthmus::ingest {
void SessionWorker::MakeState(uint32_t segment, uint32_t first_index) {
  state_ = std::make_unique<OdometryCheckpointState>(record_, sensor_, options_.odometry,
                                                     options_.submap, segment, first_index);
}

void SessionWorker::RememberSubmaps(const ResumePoint& resume, Cloud* around) {
  const auto stored =
      std::find_if(resume.segments.begin(), resume.segments.end(),
                   [this](const auto& segment) { return segment.segment == state_->segment; });
  if (stored == resume.segments.end() || !stored->for_each_submap) return;
  stored->for_each_submap([&](const Submap& submap) {
    mutex_.AssertHeld();
    state_->odometry.Remember(submap);
    if (around == nullptr || !newest_) return;
    for (const SubmapPoint& point : submap.points) {
      const Eigen::Vector3d p = submap.T_odom_submap * point.Position().cast<double>();
      if ((p - newest_->pose.translation()).norm() > options_.odometry.map.radius_m) continue;
      const Eigen::Vector3f q = p.cast<float>();
      around->push_back({q.x(), q.y(), q.z(), point.intensity});
    }
  });
}

void SessionWorker::Resume(const ResumePoint& resume) {
  for (const StoredSegment& segment : resume.segments) {
    newest_.reset();  // No way leads from one segment to the next.
    for (const TrajectoryEntry& entry : segment.trajectory) FollowPose(entry, segment.segment);
    stored_until_ = {segment.segment, segment.next_index};
  }
  const std::optional<SessionCheckpoint>& checkpoint = resume.checkpoint;
  absl::Status usable = absl::DataLossError("the checkpoint is damaged");
  if (checkpoint && checkpoint->state) {
    MakeState(1, 0);
    usable = state_->Restore(*checkpoint->state, [&] {
      mutex_.AssertHeld();
      RememberSubmaps(resume, nullptr);
    });
  }
  if (!usable.ok()) {
    ResumeFromSubmaps(resume);
    status_.segment = state_->segment;
    if (!checkpoint) return;
    status_.resumed = absl::StrCat("resumed from submaps: ", usable.message());
    status_.input = status_.resumed;
    return;
  }
  if (state_->segment != stored_until_.first) newest_.reset();
  status_.last_sequence = checkpoint->sequence;
  status_.durable_sequence = checkpoint->durable_sequence;
  status_.segment = state_->segment;
  status_.scans = state_->counts;
  status_.lost_since_ns = state_->lost_since_ns;
  status_.unsaved[state_->segment] = state_->unfinished;
  for (const TrajectoryEntry& entry : state_->unfinished) FollowPose(entry, state_->segment);
}

void SessionWorker::ResumeFromSubmaps(const ResumePoint& resume) {
  StoredSegment last;
  for (const StoredSegment& segment : resume.segments) {
    const uint64_t stored = std::max(last.last_sequence, segment.last_sequence);
    last = segment;
    last.last_sequence = stored;
  }
  // Numbers that cannot be are not believed.
  const std::optional<SessionCheckpoint>& checkpoint = resume.checkpoint;
  const bool counts = checkpoint && checkpoint->durable_sequence >= last.last_sequence &&
                      checkpoint->durable_sequence <= checkpoint->sequence;
  status_.last_sequence = counts ? checkpoint->durable_sequence : last.last_sequence;
  status_.durable_sequence = status_.last_sequence;
  if (last.trajectory.empty()) {
    // Nothing is left that says where the robot was in this segment's frame, whatever it was told
    // of it.
    const bool is_new = status_.last_sequence > 0;
    MakeState(is_new ? last.segment + 1 : last.segment, is_new ? 0 : last.next_index);
    checkpoint_due_ = is_new;
    return;
  }
  MakeState(last.segment, last.next_index);
  Cloud around;
  RememberSubmaps(resume, &around);
  Trajectory recent;
  for (const TrajectoryEntry& entry : last.trajectory) {
    recent.push_back({entry.stamp_ns, entry.T_odom_sensor});
  }
  state_->clock.Advance(recent.back().stamp_ns, recent.back().stamp_ns);
  state_->odometry.Resume(around, recent);
}

// Takes note of where the robot was.
void SessionWorker::FollowPose(const TrajectoryEntry& entry, uint32_t segment) {
  if (newest_) {
    status_.travelled_m += (entry.T_odom_sensor.translation() - newest_->pose.translation()).norm();
  }
  newest_ = {entry.stamp_ns, entry.T_odom_sensor};
  newest_segment_ = segment;
}

}  // namespace isthmus::ingest
