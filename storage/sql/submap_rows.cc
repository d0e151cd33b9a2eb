#include <absl/strings/str_cat.h>

#include "storage/batch_rules.h"
#include "storage/records/matrix_codec.h"
#include "storage/records/pose_codec.h"
#include "storage/records/submap_codec.h"
#include "storage/sql/rows.h"

namespace isthmus::storage {
namespace {

// Behind "FROM submaps s JOIN sessions e ON e.key = s.session".
constexpr char kSubmapColumns[] =
    "e.id, s.submap_index, e.robot, s.T_odom_submap, s.first_sequence, s.last_sequence, "
    "s.first_stamp_ns, s.last_stamp_ns, s.keyframe_count, s.point_count, "
    "s.min_x, s.min_y, s.min_z, s.max_x, s.max_y, s.max_z, s.drift_covariance, s.content";
constexpr int kInfoColumnCount = 18;
constexpr char kFrom[] = " FROM submaps s JOIN sessions e ON e.key = s.session ";

// Zero, which says nothing, where there is none or it is not one any more.
Matrix6d ReadCovariance(const std::string& bytes) {
  ByteReader reader(bytes);
  const Matrix6d covariance = ReadSymmetric(reader);
  const bool whole = reader.ok() && reader.remaining() == 0 && covariance.allFinite();
  return whole ? covariance : Matrix6d::Zero();
}

SubmapInfo ReadInfo(const Statement& row) {
  SubmapInfo info;
  info.id = {SessionId(row.Text(0)), row.Uint32(1)};
  info.robot = RobotId(row.Text(2));
  info.T_odom_submap = UnpackPose(row.Text(3));
  info.first_sequence = row.Uint(4);
  info.last_sequence = row.Uint(5);
  info.first_stamp_ns = row.Int(6);
  info.last_stamp_ns = row.Int(7);
  info.keyframe_count = row.Uint32(8);
  info.point_count = row.Uint(9);
  info.drift_covariance = row.IsNull(16) ? Matrix6d::Zero() : ReadCovariance(row.Text(16));
  if (!row.IsNull(17)) info.content = row.Uint(17);
  if (row.IsNull(10)) return info;  // No points: an empty box.
  info.bounds.min = {row.Real(10), row.Real(11), row.Real(12)};
  info.bounds.max = {row.Real(13), row.Real(14), row.Real(15)};
  return info;
}

// Returns the row's key.
absl::StatusOr<int64_t> AddInfo(Connection& database, int64_t session_key,
                                const SubmapRow& submap) {
  const SubmapInfo& info = submap.info;
  Statement insert = database.Prepare(
      "INSERT INTO submaps (session, submap_index, T_odom_submap, first_sequence, last_sequence, "
      "first_stamp_ns, last_stamp_ns, keyframe_count, point_count, min_x, min_y, min_z, max_x, "
      "max_y, max_z, drift_covariance, content) "
      "VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?) RETURNING key");
  insert.Bind(session_key)
      .Bind(info.id.index)
      .BindBlob(PackPose(info.T_odom_submap))
      .Bind(info.first_sequence)
      .Bind(info.last_sequence)
      .Bind(info.first_stamp_ns)
      .Bind(info.last_stamp_ns)
      .Bind(info.keyframe_count)
      .Bind(info.point_count);
  for (const Eigen::Vector3d& corner : {info.bounds.min, info.bounds.max}) {
    for (int axis = 0; axis < 3; ++axis) {
      if (info.bounds.empty()) {
        insert.BindNull();
      } else {
        insert.Bind(corner[axis]);
      }
    }
  }
  if (info.drift_covariance.isZero(0)) {
    insert.BindNull();
  } else {
    std::string covariance;
    AppendSymmetric(info.drift_covariance, covariance);
    insert.BindBlob(covariance);
  }
  insert.Bind(info.content);
  const absl::StatusOr<bool> has_row = insert.Step();
  if (!has_row.ok()) return has_row.status();
  const int64_t key = insert.Int(0);
  if (auto end = insert.Step(); !end.ok()) return end.status();
  return key;
}

}  // namespace

absl::Status DamagedSubmap(const SubmapId& submap, const absl::Status& why) {
  return absl::DataLossError(
      absl::StrCat("submap ", ToString(submap), " is damaged: ", why.message()));
}

absl::Status AddSubmap(Connection& database, const SubmapRow& submap) {
  const SubmapInfo& info = submap.info;
  absl::StatusOr<std::optional<int64_t>> session = FindSessionKey(database, info.id.session);
  if (!session.ok()) return session.status();
  if (!*session) return absl::InternalError("a submap of an unchecked session");
  const absl::StatusOr<int64_t> key = AddInfo(database, **session, submap);
  if (!key.ok()) return key.status();
  return database.Prepare("INSERT INTO submap_blobs (submap, data) VALUES (?, ?)")
      .Bind(*key)
      .BindBlob(submap.blob)
      .Run();
}

absl::Status FillInContent(Connection& database, const SubmapId& submap, uint64_t content) {
  return database
      .Prepare(
          "UPDATE submaps SET content = ? WHERE content IS NULL AND submap_index = ? AND session = "
          "(SELECT key FROM sessions WHERE id = ?)")
      .Bind(content)
      .Bind(submap.index)
      .Bind(submap.session.value())
      .Run();
}

absl::StatusOr<std::shared_ptr<const Submap>> UnpackSubmap(const SubmapRow& row) {
  const SubmapInfo& info = row.info;
  auto submap = std::make_shared<Submap>();
  submap->id = info.id;
  submap->robot = info.robot;
  submap->T_odom_submap = info.T_odom_submap;
  submap->drift_covariance = info.drift_covariance;
  submap->first_sequence = info.first_sequence;
  submap->last_sequence = info.last_sequence;
  submap->first_stamp_ns = info.first_stamp_ns;
  submap->last_stamp_ns = info.last_stamp_ns;
  absl::Status status = DecodeSubmap(row.blob, *submap);
  const bool complete =
      submap->keyframes.size() == info.keyframe_count && submap->points.size() == info.point_count;
  if (status.ok() && !complete) status = absl::DataLossError("it is another submap's");
  if (!status.ok()) return DamagedSubmap(info.id, status);
  return submap;
}

absl::Status RemoveSubmap(Connection& database, int64_t session_key, uint32_t index) {
  const absl::StatusOr<int64_t> removed =
      database.Prepare("DELETE FROM submaps WHERE session = ? AND submap_index = ?")
          .Bind(session_key)
          .Bind(index)
          .Change();
  if (!removed.ok() || *removed == 0) return removed.status();
  return database.Prepare("DELETE FROM trajectory WHERE session = ? AND submap_index = ?")
      .Bind(session_key)
      .Bind(index)
      .Run();
}

absl::StatusOr<std::optional<int64_t>> FindSubmapKey(Connection& database, const SubmapId& submap) {
  Statement row = database.Prepare(
      "SELECT s.key FROM submaps s JOIN sessions e ON e.key = s.session "
      "WHERE e.id = ? AND s.submap_index = ?");
  absl::StatusOr<bool> found = row.Bind(submap.session.value()).Bind(submap.index).Step();
  if (!found.ok()) return found.status();
  if (!*found) return std::nullopt;
  return row.Int(0);
}

absl::StatusOr<SubmapRow> FindSubmap(Connection& database, const SubmapId& submap) {
  Statement row = database.Prepare(
      std::string("SELECT ") + kSubmapColumns + ", coalesce(b.data, '')" + kFrom +
      "LEFT JOIN submap_blobs b ON b.submap = s.key WHERE e.id = ? AND s.submap_index = ?");
  absl::StatusOr<bool> found = row.Bind(submap.session.value()).Bind(submap.index).Step();
  if (absl::IsDataLoss(found.status())) return DamagedSubmap(submap, found.status());
  if (!found.ok()) return found.status();
  if (!*found) return UnknownSubmap(submap);
  if (row.Text(kInfoColumnCount).empty())
    return DamagedSubmap(submap, absl::DataLossError("its points are not there"));
  return SubmapRow{ReadInfo(row), row.Text(kInfoColumnCount)};
}

absl::StatusOr<std::vector<SubmapInfo>> SelectSubmaps(Connection& database,
                                                      std::optional<int64_t> session_key) {
  const std::string select = std::string("SELECT ") + kSubmapColumns + kFrom;
  if (!session_key) {
    return database.Prepare(select + "ORDER BY e.id, s.submap_index").ReadAll(ReadInfo);
  }
  return database.Prepare(select + "WHERE s.session = ? ORDER BY s.submap_index")
      .Bind(*session_key)
      .ReadAll(ReadInfo);
}

absl::StatusOr<std::vector<SubmapInfo>> SelectSubmapsBehind(Connection& database, int64_t key) {
  return database
      .Prepare(std::string("SELECT ") + kSubmapColumns + kFrom +
               "WHERE s.key > ? ORDER BY e.id, s.submap_index")
      .Bind(key)
      .ReadAll(ReadInfo);
}

absl::StatusOr<std::vector<SubmapId>> SelectSubmapIds(Connection& database) {
  return database
      .Prepare(std::string("SELECT e.id, s.submap_index") + kFrom + "ORDER BY e.id, s.submap_index")
      .ReadAll([](const Statement& row) {
        return SubmapId{SessionId(row.Text(0)), row.Uint32(1)};
      });
}

}  // namespace isthmus::storage
