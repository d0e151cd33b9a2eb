#include "storage/sql/tables.h"

#include <sstream>

namespace isthmus::storage {
namespace {

// Columns as "name:kind", where the kind is n, r, t or b.
Table Describe(const std::string& name, size_t keys, const std::string& columns) {
  Table table{name, {}, keys};
  std::istringstream words(columns);
  std::string word;
  while (words >> word) {
    using Kind = TableColumn::Kind;
    const char kind = word.back();
    word.resize(word.size() - 2);
    table.columns.push_back({word, kind == 'n'   ? Kind::kNumber
                                   : kind == 'r' ? Kind::kReal
                                   : kind == 't' ? Kind::kText
                                                 : Kind::kBlob});
    table.has_blobs = table.has_blobs || word == "data" || word == "edges";
  }
  table.counts_keys = table.columns[0].name == "key";
  return table;
}

}  // namespace

const std::vector<Table>& MapTables() {
  static const std::vector<Table> kTables = {
      Describe("sessions", 1,
               "key:n id:t robot:t sensor:t T_base_sensor:b state:n created_ns:n finished_ns:n "
               "odometry:t request_id:t segment:n first_segment:n scans_ok:n scans_degenerate:n "
               "scans_lost:n scans_rejected:n when_behind:n scans_skipped:n"),
      Describe("trajectory", 2, "session:n sequence:n stamp_ns:n submap_index:n T_odom_sensor:b"),
      Describe("submaps", 1,
               "key:n session:n submap_index:n T_odom_submap:b first_sequence:n last_sequence:n "
               "first_stamp_ns:n last_stamp_ns:n keyframe_count:n point_count:n min_x:r min_y:r "
               "min_z:r max_x:r max_y:r max_z:r drift_covariance:b"),
      Describe("submap_blobs", 1, "submap:n data:b"),
      Describe("features", 1, "key:n submap:n kind:t crc32c:n data:b"),
      Describe("matches", 2,
               "a:n b:n T_a_b:b state:t reason:t detail:t confidence:r overlap:r inliers:n "
               "residual_m:r free_space:r comparisons:n runner_up:r matcher:t submaps_a:n "
               "submaps_b:n computed_ns:n inlier_ratio:r shared_area_m2:r hold:r strain:r "
               "candidates:n edges:b"),
      Describe("match_stages", 3, "a:n b:n position:n stage:t ms:r"),
      Describe("match_rivals", 3,
               "a:n b:n position:n T_a_b:b state:t reason:t confidence:r matcher:t overlap:r "
               "free_space:r comparisons:n shared_area_m2:r edges:b"),
      Describe("verdicts", 2, "a:n b:n ruling:t T_a_b:b note:t given_ns:n"),
      Describe("loops", 1,
               "id:n session:n submap_a:n submap_b:n T_a_b:b confidence:r overlap:r residual_m:r "
               "free_space:r comparisons:n source:t detail:t computed_ns:n edges:b rejected:n "
               "note:t"),
      Describe("anchors", 1,
               "submap:n T_map_submap:b sigma_xy_m:r sigma_z_m:r sigma_deg:r note:t given_ns:n"),
      Describe("datum", 1,
               "id:n latitude_deg:r longitude_deg:r altitude_m:r heading_deg:r given_ns:n"),
      Describe("checkpoints", 1, "session:n sequence:n durable_sequence:n crc32c:n data:b"),
      Describe("matching_progress", 1,
               "session:n next_for_loops:n next_at_choice:n max_pairs:n max_searched:n "
               "max_joined:n"),
      Describe("revisions", 1,
               "revision:n stamp_ns:n cause:t added:n moved:n removed:n largest_move_m:r"),
      Describe("revision_matches", 2, "revision:n position:n a:t b:t"),
      Describe("revision_loops", 2, "revision:n position:n loop:n"),
      Describe("placements", 2, "revision:n session:t component:n reference:t T_map_odom:b"),
      Describe("submap_moves", 3,
               "revision:n session:t submap_index:n T_before:b frame_before:t T_after:b "
               "frame_after:t"),
      Describe("placed_submaps", 2, "session:t submap_index:n T_map_submap:b"),
      Describe("events", 1,
               "number:n time_ns:n kind:t who:t peer:t request_id:t robot:t session:t text:t"),
  };
  return kTables;
}

}  // namespace isthmus::storage
