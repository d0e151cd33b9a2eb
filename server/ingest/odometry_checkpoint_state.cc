#include "server/ingest/odometry_checkpoint_state.h"

#include <absl/strings/str_cat.h>

#include <utility>

#include "core/codec/zstd_frame.h"
#include "core/state_codec.h"
#include "server/ingest/limits.h"

namespace isthmus::ingest {
namespace {

constexpr char kStateMagic[] = "ISES";
constexpr uint32_t kStateVersion = 4;  // Format.

// In the order of its members; `Entry` is const when they are written.
template <typename Entry, typename Io>
void EntryFields(Entry& entry, Io& io) {
  io(entry.sequence, entry.stamp_ns, entry.T_odom_sensor, entry.submap_index);
}

void WriteEntries(const std::vector<TrajectoryEntry>& entries, StateWriter& io) {
  io(uint64_t{entries.size()});
  for (const TrajectoryEntry& entry : entries) EntryFields(entry, io);
}

void ReadEntries(StateReader& io, std::vector<TrajectoryEntry>& entries) {
  constexpr size_t kEntrySize = 2 * 8 + 7 * 8 + 4;
  for (size_t left = io.Count(kEntrySize); left > 0; --left) {
    EntryFields(entries.emplace_back(), io);
  }
}

floam::OdometryOptions Mounted(floam::OdometryOptions options, const SessionRecord& record) {
  options.R_base_sensor = record.T_base_sensor.rotation();
  return options;
}

}  // namespace

OdometryCheckpointState::OdometryCheckpointState(const SessionRecord& record,
                                                 const floam::SensorModel& sensor,
                                                 const floam::OdometryOptions& odometry_options,
                                                 const floam::SubmapOptions& submap_options,
                                                 uint32_t in_segment, uint32_t first_index)
    : odometry(sensor, Mounted(odometry_options, record)),
      segment(in_segment),
      session_(record.id),
      robot_(record.robot),
      submap_options_(submap_options) {
  MakeBuilder(first_index);
}

void OdometryCheckpointState::MakeBuilder(uint32_t first_index) {
  builder.emplace(SegmentId(session_, segment), robot_, submap_options_, first_index);
}

void OdometryCheckpointState::BeginSegment() {
  ++segment;
  MakeBuilder(0);
  unfinished.clear();
}

absl::StatusOr<std::string> OdometryCheckpointState::Save() const {
  StateWriter writer;
  const codec::TimeReader::Memory times = decoder.memory();
  writer(times.unit_s, times.turn_s, times.end_s, times.zero, clock, blind_scans);
  writer(segment, odometry_segment, counts.ok, counts.degenerate, counts.lost, counts.rejected,
         counts.skipped, lost_since_ns, lost_scans);
  WriteEntries(unfinished, writer);
  writer(odometry.Save(), builder->Save());
  return codec::PackZstd(SealState(kStateMagic, kStateVersion, 0, writer.Take()), kStateZstdLevel);
}

absl::Status OdometryCheckpointState::Restore(const std::string& saved,
                                              const std::function<void()>& remember) {
  const absl::StatusOr<std::string> state = codec::UnpackZstd(saved, kMaxStateBytes);
  if (!state.ok()) return state.status();
  absl::StatusOr<StateReader> reader =
      OpenState(kStateMagic, kStateVersion, 0, *state, "the session");
  if (!reader.ok()) return reader.status();
  codec::TimeReader::Memory times;
  std::string saved_odometry, saved_builder;
  (*reader)(times.unit_s, times.turn_s, times.end_s, times.zero, clock, blind_scans);
  (*reader)(segment, odometry_segment, counts.ok, counts.degenerate, counts.lost, counts.rejected,
            counts.skipped, lost_since_ns, lost_scans);
  ReadEntries(*reader, unfinished);
  (*reader)(saved_odometry, saved_builder);
  if (!reader->ok() || reader->remaining() > 0) {
    return absl::DataLossError("the state of the session is damaged: it contradicts itself");
  }
  decoder.Restore(times);
  remember();
  if (absl::Status status = odometry.Restore(saved_odometry); !status.ok()) return status;
  MakeBuilder(0);
  return builder->Restore(saved_builder);
}

}  // namespace isthmus::ingest
