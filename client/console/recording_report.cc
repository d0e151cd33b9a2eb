#include "client/console/recording_report.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <absl/strings/str_join.h>
#include <absl/time/time.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "client/console/say.h"
#include "client/readers/shell_word.h"
#include "client/readers/started_reader.h"
#include "core/codec/payload_layout.h"
#include "core/codec/scan_decoder.h"
#include "core/geometry/near_origin.h"
#include "core/nanoseconds.h"
#include "core/scan_clock.h"

namespace isthmus::cli {
namespace {

std::string FieldsText(const PointPayload& payload) {
  return absl::StrJoin(payload.fields, ", ", [](std::string* out, const PointField& field) {
    absl::StrAppend(out, field.name, " ", codec::ToString(field.type));
  });
}

// Gathers what the scans of a topic show, one after the other.
class TopicSurvey {
 public:
  explicit TopicSurvey(TopicReport& report) : report_(report) {}

  void Add(const readers::RecordedScan& scan) {
    if (!TakeStamp(scan)) return;
    if (report_.scans == 0) {
      report_.first_ns = scan.end_stamp_ns;
      report_.fields = FieldsText(scan.payload);
      LookFar(scan.payload);
    } else if (scan.end_stamp_ns > report_.last_ns) {
      intervals_ns_.push_back(scan.end_stamp_ns - report_.last_ns);
    } else if (!was_set_back_) {
      was_set_back_ = true;
      report_.assumptions.push_back(
          absl::StrCat("the stamps go back at ", scan.name, ": the clock was probably set"));
    }
    report_.last_ns = scan.end_stamp_ns;
    ++report_.scans;
    report_.points += codec::PointCount(scan.payload);
    // Whole turns teach the unit of times: the first few are enough, unless their times are empty.
    constexpr uint64_t kDecoded = 5;
    const bool are_empty = decoder_.memory().zero == codec::TimeReader::Zero::kInstant;
    if (report_.scans > kDecoded && !are_empty) return;
    const auto decoded = decoder_.Decode(scan.payload, report_.scans, scan.end_stamp_ns);
    if (!decoded.ok()) {
      AddError(scan.name, decoded.status());
      return;
    }
    for (const ScanPoint& point : decoded->points)
      highest_ring_ = std::max(highest_ring_, point.ring);
    report_.rings = !decoded->has_ring
                        ? "none in the points"
                        : absl::StrCat("up to ", highest_ring_ + 1, ", ", decoder_.fields().ring);
    report_.times = decoded->has_time ? decoder_.fields().time : "none in the points";
  }

  void AddError(const std::string& name, const absl::Status& error) {
    if (report_.errors++ > 0) return;
    report_.first_error =
        absl::StrCat(name, name.empty() ? "" : ": ", std::string(error.message()));
  }

  void Finish() {
    if (intervals_ns_.empty()) return;
    std::vector<int64_t> sorted = intervals_ns_;
    std::nth_element(sorted.begin(), sorted.begin() + sorted.size() / 2, sorted.end());
    const int64_t median = sorted[sorted.size() / 2];
    report_.interval_s = static_cast<double>(median) / kNsPerSecond;
    for (const int64_t interval : intervals_ns_) {
      if (interval <= median + median / 2) continue;
      ++report_.gaps;
      report_.longest_gap_s =
          std::max(report_.longest_gap_s, static_cast<double>(interval) / kNsPerSecond);
    }
  }

 private:
  // As the server takes it; false where it is refused.
  bool TakeStamp(const readers::RecordedScan& scan) {
    const auto reading = clock_.Read(scan.end_stamp_ns);
    if (!reading.ok()) {
      AddError(scan.name, reading.status());
      return false;
    }
    clock_.Advance(scan.end_stamp_ns, reading->time_ns);
    if (report_.scans > 0) {
      // The time of a pause is that of the stamps; behind a clock that was set they tell none.
      const int64_t between_ns = scan.end_stamp_ns - report_.last_ns;
      const int64_t passed_ns = between_ns > 0 ? between_ns : reading->time_ns - last_time_ns_;
      report_.duration_s += static_cast<double>(passed_ns) / kNsPerSecond;
    }
    last_time_ns_ = reading->time_ns;
    return true;
  }

  // Points of a sensor are around it; those of a map may be anywhere on the Earth.
  void LookFar(const PointPayload& cloud) {
    std::vector<double> xyz[3];
    const char* const names[] = {"x", "y", "z"};
    for (int axis = 0; axis < 3; ++axis) {
      const PointField* field = codec::FindField(cloud, {names[axis]});
      if (field != nullptr) xyz[axis] = codec::ReadColumn(cloud, *field);
    }
    const Eigen::Vector3d shift = ShiftToOrigin(MiddleOf(xyz[0], xyz[1], xyz[2]));
    if (shift.isZero()) return;
    report_.assumptions.push_back(
        absl::StrCat(ShiftText("the cloud", shift), " by upload --clouds-in odom and merge"));
  }

  TopicReport& report_;
  codec::ScanDecoder decoder_;
  ScanClock clock_;
  int64_t last_time_ns_ = 0;  // By that clock.
  bool was_set_back_ = false;
  std::vector<int64_t> intervals_ns_;
  uint16_t highest_ring_ = 0;
};

TopicReport ReadTopic(const readers::Recording& recording, size_t index,
                      const readers::ReadOptions& options, uint64_t most_scans,
                      const std::function<void()>& seen) {
  TopicReport report;
  report.topic = recording.scan_topics()[index];
  auto reader = recording.OpenScans(index, options);
  if (!reader.ok()) {
    report.error = std::string(reader.status().message());
    return report;
  }
  readers::StartedReader started(*std::move(reader));
  TopicSurvey survey(report);
  while (report.scans < most_scans) {
    const auto scan = started.Next();
    if (!scan.ok()) {
      survey.AddError("", scan.status());
      continue;
    }
    if (!scan->has_value()) break;
    survey.Add(**scan);
    seen();
  }
  report.is_complete = report.scans < most_scans;
  survey.Finish();
  report.sensor = options.sensor.empty() ? started.sensor() : options.sensor;
  for (std::string& assumption : started.Assumptions()) {
    report.assumptions.push_back(std::move(assumption));
  }
  if (report.scans == 0) {
    report.error = report.errors > 0 ? report.first_error : "no scan on this topic";
  }
  return report;
}

// "robot_1" for the first of several.
std::string PushCommand(const RecordingReport& report) {
  std::vector<const TopicReport*> usable;
  for (const TopicReport& topic : report.topics) {
    if (topic.error.empty()) usable.push_back(&topic);
  }
  if (usable.empty()) return "";
  std::string command = "isthmus push " + readers::ShellWord(report.path);
  if (usable.size() == 1) {
    absl::StrAppend(&command, " --robot NAME");
    if (report.topics.size() > 1) {
      absl::StrAppend(&command, " --topic ", readers::ShellWord(usable[0]->topic.name));
    }
    if (usable[0]->sensor.empty()) absl::StrAppend(&command, " --sensor SENSOR");
    return command;
  }
  for (size_t i = 0; i < usable.size(); ++i) {
    absl::StrAppend(&command, " --topic ",
                    readers::ShellWord(absl::StrCat(usable[i]->topic.name, "=robot_", i + 1)));
  }
  return command;
}

std::string StampText(int64_t stamp_ns) {
  if (stamp_ns < 1'000'000 * kNsPerSecond) return absl::StrFormat("%.3f s", stamp_ns / 1e9);
  return absl::FormatTime("%Y-%m-%d %H:%M:%E3S UTC", absl::FromUnixNanos(stamp_ns),
                          absl::UTCTimeZone());
}

void PrintTopic(const TopicReport& report) {
  Say("\n%s (%s)\n", report.topic.name.empty() ? "scans" : report.topic.name, report.topic.type);
  if (!report.error.empty()) {
    Say("  cannot be read: %s\n", report.error);
    return;
  }
  Say("  scans    %d%s in %.1f s, %d points each\n", report.scans,
      report.is_complete ? "" : " (the first; --all reads all)", report.duration_s,
      report.points / report.scans);
  Say("  from     %s\n  to       %s\n", StampText(report.first_ns), StampText(report.last_ns));
  if (report.interval_s > 0) {
    Say("  rate     %.2f Hz, %s\n", 1 / report.interval_s,
        report.gaps == 0
            ? "no gaps"
            : absl::StrFormat("%d gaps, the longest %.2f s", report.gaps, report.longest_gap_s));
  }
  Say("  sensor   %s\n  rings    %s\n  times    %s\n  fields   %s\n",
      report.sensor.empty() ? "unknown: give it with --sensor" : report.sensor, report.rings,
      report.times, report.fields);
  for (const std::string& assumption : report.assumptions) {
    Say("  assumed  %s\n", assumption);
  }
  if (report.errors > 0) {
    Say("  errors   %d, the first: %s\n", report.errors, report.first_error);
  }
}

Json TopicJson(const TopicReport& report) {
  return {{"topic", report.topic.name},
          {"type", report.topic.type},
          {"messages", report.topic.messages ? Json(*report.topic.messages) : Json(nullptr)},
          {"error", report.error},
          {"scans", report.scans},
          {"complete", report.is_complete},
          {"points", report.points},
          {"first_stamp_ns", report.first_ns},
          {"last_stamp_ns", report.last_ns},
          {"duration_s", report.duration_s},
          {"interval_s", report.interval_s},
          {"gaps", report.gaps},
          {"longest_gap_s", report.longest_gap_s},
          {"sensor", report.sensor},
          {"rings", report.rings},
          {"times", report.times},
          {"fields", report.fields},
          {"assumptions", report.assumptions},
          {"errors", report.errors},
          {"first_error", report.first_error}};
}

}  // namespace

absl::StatusOr<RecordingReport> ReadReport(const std::string& path,
                                           const readers::ReadOptions& options, uint64_t most_scans,
                                           const std::function<void()>& seen) {
  const auto recording = readers::OpenRecording(path);
  if (!recording.ok()) return recording.status();
  RecordingReport report;
  report.path = path;
  report.kind = (*recording)->kind();
  for (size_t i = 0; i < (*recording)->scan_topics().size(); ++i) {
    report.topics.push_back(ReadTopic(**recording, i, options, most_scans, seen));
  }
  report.notes = (*recording)->notes();
  report.gnss = (*recording)->gnss_topics();
  auto transforms = (*recording)->ReadStaticTransforms();
  if (transforms.ok()) {
    report.transforms = *std::move(transforms);
  } else {
    report.notes.emplace_back(transforms.status().message());
  }
  report.command = PushCommand(report);
  return report;
}

void PrintText(const RecordingReport& report) {
  Say("%s: %s\n", report.path, report.kind);
  for (const std::string& note : report.notes) Say("  note     %s\n", note);
  for (const TopicReport& topic : report.topics) PrintTopic(topic);
  for (const readers::GnssTopic& gnss : report.gnss) {
    Say("\n%s (GNSS)\n", gnss.name);
    if (gnss.messages) Say("  fixes    %d\n", *gnss.messages);
    Say("  use      --gnss %s anchors the map by them\n", readers::ShellWord(gnss.name));
  }
  for (const readers::StaticTransform& edge : report.transforms) {
    const Eigen::Vector3d t = edge.T_parent_child.translation();
    Say("\n%s -> %s at %.3f %.3f %.3f m (static)\n", edge.parent, edge.child, t.x(), t.y(), t.z());
  }
  if (!report.command.empty()) Say("\nTo push it:\n  %s\n", report.command);
}

Json ToJson(const RecordingReport& report) {
  Json topics = Json::array(), gnss = Json::array(), transforms = Json::array();
  for (const TopicReport& topic : report.topics) topics.push_back(TopicJson(topic));
  for (const readers::GnssTopic& topic : report.gnss) {
    gnss.push_back({{"topic", topic.name},
                    {"messages", topic.messages ? Json(*topic.messages) : Json(nullptr)}});
  }
  for (const readers::StaticTransform& edge : report.transforms) {
    transforms.push_back({{"parent", edge.parent},
                          {"child", edge.child},
                          {"T_parent_child", ToJson(edge.T_parent_child)}});
  }
  return {{"path", report.path},      {"kind", report.kind},
          {"notes", report.notes},    {"topics", std::move(topics)},
          {"gnss", std::move(gnss)},  {"static_transforms", std::move(transforms)},
          {"command", report.command}};
}

}  // namespace isthmus::cli
