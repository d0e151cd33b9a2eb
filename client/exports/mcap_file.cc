#include "client/exports/mcap_file.h"

#include <absl/strings/str_cat.h>
#include <google/protobuf/descriptor.h>
#include <google/protobuf/descriptor.pb.h>

#include <algorithm>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include "client/exports/foxglove.pb.h"
#include "client/exports/tracks.h"
#include "core/formats/mcap_writer.h"
#include "core/io/output_file.h"
#include "core/nanoseconds.h"

namespace isthmus::exports {
namespace {

constexpr char kMapFrame[] = "map";

// The message's file and those it needs, each before who needs it.
void AddFile(const google::protobuf::FileDescriptor& file,
             google::protobuf::FileDescriptorSet* files) {
  for (int i = 0; i < file.dependency_count(); ++i) AddFile(*file.dependency(i), files);
  file.CopyTo(files->add_file());
}

template <typename Message>
void PutStamp(int64_t stamp_ns, Message* message) {
  message->mutable_timestamp()->set_seconds(stamp_ns / kNsPerSecond);
  message->mutable_timestamp()->set_nanos(static_cast<int32_t>(stamp_ns % kNsPerSecond));
}

template <typename Vector, typename Rotation>
void PutPose(const Pose& pose, Vector* translation, Rotation* rotation) {
  translation->set_x(pose.translation().x());
  translation->set_y(pose.translation().y());
  translation->set_z(pose.translation().z());
  rotation->set_x(pose.rotation().x());
  rotation->set_y(pose.rotation().y());
  rotation->set_z(pose.rotation().z());
  rotation->set_w(pose.rotation().w());
}

void PutPose(const Pose& pose, foxglove::Pose* message) {
  PutPose(pose, message->mutable_position(), message->mutable_orientation());
}

foxglove::PointCloud CloudOf(const std::vector<MapPoint>& points, int64_t stamp_ns) {
  foxglove::PointCloud cloud;
  PutStamp(stamp_ns, &cloud);
  cloud.set_frame_id(kMapFrame);
  PutPose(Pose(), cloud.mutable_pose());
  cloud.set_point_stride(kMapRecordBytes);
  const auto add = [&cloud](const char* name, auto type) {
    foxglove::PackedElementField& field = *cloud.add_fields();
    field.set_name(name);
    field.set_offset(4 * static_cast<uint32_t>(cloud.fields_size() - 1));
    field.set_type(type);
  };
  for (const char* name : {"x", "y", "z", "intensity"}) {
    add(name, foxglove::PackedElementField::FLOAT32);
  }
  for (const char* name : {"robot", "label"}) add(name, foxglove::PackedElementField::UINT32);
  cloud.mutable_data()->resize(points.size() * kMapRecordBytes);
  CopyMapRecords(points, cloud.mutable_data()->data());
  return cloud;
}

class FoxgloveFile {
 public:
  explicit FoxgloveFile(io::OutputFile* output)
      : writer_([this, output](const std::string& bytes) {
          status_ = output->Append(bytes);
          return status_.ok();
        }) {}

  template <typename Message>
  uint16_t AddTopic(const std::string& topic) {
    const google::protobuf::Descriptor& type = *Message::descriptor();
    auto [known, is_new] = schemas_.try_emplace(type.full_name(), uint16_t{0});
    if (is_new) {
      google::protobuf::FileDescriptorSet files;
      AddFile(*type.file(), &files);
      known->second = writer_.AddSchema(type.full_name(), "protobuf", files.SerializeAsString());
    }
    return writer_.AddChannel(known->second, topic, "protobuf");
  }
  void Write(uint16_t channel, int64_t stamp_ns, const google::protobuf::Message& message) {
    writer_.Write(channel, stamp_ns, message.SerializeAsString());
  }
  absl::Status Finish() {
    writer_.Finish();
    return status_;
  }
  const absl::Status& status() const { return status_; }

 private:
  absl::Status status_;
  std::map<std::string, uint16_t> schemas_;
  formats::McapWriter writer_;  // Writes from its making on.
};

// The cloud, in messages of at most kCloudPoints.
absl::Status AddCloud(client::Client& client, const RegionQuery& query, int64_t stamp_ns,
                      const CloudProgress& progress, FoxgloveFile* file, CloudSummary* summary) {
  std::vector<MapPoint> held;
  int parts = 0;
  const auto flush = [&] {
    const std::string topic = parts == 0 ? "/map" : absl::StrCat("/map/", parts + 1);
    ++parts;
    file->Write(file->AddTopic<foxglove::PointCloud>(topic), stamp_ns, CloudOf(held, stamp_ns));
    held.clear();
  };
  const absl::Status read = client.QueryRegion(query, [&](const RegionChunk& chunk) {
    summary->revision = chunk.revision;
    summary->points += chunk.points.size();
    held.insert(held.end(), chunk.points.begin(), chunk.points.end());
    if (held.size() >= kCloudPoints) flush();
    if (progress) progress(summary->points);
    return file->status().ok();
  });
  if (!file->status().ok()) return file->status();
  if (!read.ok()) return read;
  if (!held.empty() || parts == 0) flush();
  return absl::OkStatus();
}

struct Step {
  int64_t stamp_ns = 0;
  size_t track = 0;
  const Pose* pose = nullptr;
};

void AddPaths(const std::vector<Track>& tracks, int64_t stamp_ns, FoxgloveFile* file) {
  for (const Track& track : tracks) {
    const uint16_t topic =
        file->AddTopic<foxglove::PosesInFrame>(absl::StrCat("/", track.session.value(), "/path"));
    foxglove::PosesInFrame path;
    PutStamp(stamp_ns, &path);
    path.set_frame_id(kMapFrame);
    for (const StampedPose& pose : track.poses) PutPose(pose.pose, path.add_poses());
    file->Write(topic, stamp_ns, path);
  }
}

void AddSteps(const std::vector<Track>& tracks, FoxgloveFile* file) {
  std::vector<Step> steps;
  std::vector<uint16_t> topics;
  const uint16_t transforms = file->AddTopic<foxglove::FrameTransform>("/tf");
  for (size_t i = 0; i < tracks.size(); ++i) {
    topics.push_back(file->AddTopic<foxglove::PoseInFrame>(
        absl::StrCat("/", tracks[i].session.value(), "/pose")));
    for (const StampedPose& pose : tracks[i].poses) {
      steps.push_back({pose.stamp_ns, i, &pose.pose});
    }
  }
  std::stable_sort(steps.begin(), steps.end(),
                   [](const Step& a, const Step& b) { return a.stamp_ns < b.stamp_ns; });
  for (const Step& step : steps) {
    foxglove::FrameTransform transform;
    PutStamp(step.stamp_ns, &transform);
    transform.set_parent_frame_id(kMapFrame);
    transform.set_child_frame_id(tracks[step.track].robot.value());
    PutPose(*step.pose, transform.mutable_translation(), transform.mutable_rotation());
    file->Write(transforms, step.stamp_ns, transform);
    foxglove::PoseInFrame pose;
    PutStamp(step.stamp_ns, &pose);
    pose.set_frame_id(kMapFrame);
    PutPose(*step.pose, pose.mutable_pose());
    file->Write(topics[step.track], step.stamp_ns, pose);
  }
}

}  // namespace

absl::StatusOr<CloudSummary> WriteMcap(client::Client& client, const RegionQuery& query,
                                       const std::string& path, const CloudProgress& progress) {
  auto tracks = ReadTracks(client, query.component, query.robot);
  if (!tracks.ok()) return tracks.status();
  std::erase_if(*tracks, [](const Track& track) { return track.poses.empty(); });
  int64_t first_ns = std::numeric_limits<int64_t>::max();
  for (const Track& track : *tracks) {
    first_ns = std::min(first_ns, track.poses.front().stamp_ns);
  }
  if (tracks->empty()) first_ns = 0;
  io::OutputFile output(path);
  if (absl::Status status = output.Open(); !status.ok()) return status;
  FoxgloveFile file(&output);
  CloudSummary summary;
  absl::Status status = AddCloud(client, query, first_ns, progress, &file, &summary);
  if (!status.ok()) return status;
  AddPaths(*tracks, first_ns, &file);
  AddSteps(*tracks, &file);
  status = file.Finish();
  if (status.ok()) status = output.Commit();
  if (!status.ok()) return status;
  return summary;
}

}  // namespace isthmus::exports
