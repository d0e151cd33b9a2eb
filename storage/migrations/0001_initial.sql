-- The first schema. Poses are BLOBs of seven little-endian float64: qx qy qz qw tx ty tz. Times are
-- nanoseconds since the Unix epoch. Lengths are metres.

CREATE TABLE sessions (
  key INTEGER PRIMARY KEY,  -- In order of creation; what other tables refer to.
  id TEXT NOT NULL UNIQUE,
  robot TEXT NOT NULL,
  sensor TEXT NOT NULL,
  T_base_sensor BLOB NOT NULL,
  state INTEGER NOT NULL CHECK (state IN (0, 1)),  -- 0 active, 1 finished.
  created_ns INTEGER NOT NULL,
  finished_ns INTEGER NOT NULL  -- 0 while active.
) STRICT;

-- One row per processed scan, lying in order of sequence within its session.
CREATE TABLE trajectory (
  session INTEGER NOT NULL REFERENCES sessions (key) ON DELETE CASCADE,
  sequence INTEGER NOT NULL,
  stamp_ns INTEGER NOT NULL,
  submap_index INTEGER NOT NULL,
  T_odom_sensor BLOB NOT NULL,
  PRIMARY KEY (session, sequence)
) STRICT, WITHOUT ROWID;

-- What is known of a submap without its points. Bounds are in the submap frame and NULL when there
-- are no points.
CREATE TABLE submaps (
  key INTEGER PRIMARY KEY,
  session INTEGER NOT NULL REFERENCES sessions (key) ON DELETE CASCADE,
  submap_index INTEGER NOT NULL,
  T_odom_submap BLOB NOT NULL,
  first_sequence INTEGER NOT NULL,
  last_sequence INTEGER NOT NULL,
  first_stamp_ns INTEGER NOT NULL,
  last_stamp_ns INTEGER NOT NULL,
  keyframe_count INTEGER NOT NULL,
  point_count INTEGER NOT NULL,
  min_x REAL, min_y REAL, min_z REAL,
  max_x REAL, max_y REAL, max_z REAL,
  UNIQUE (session, submap_index)
) STRICT;

-- Keyframes and points; see docs/storage-format.md. Apart from `submaps`, so that listing those
-- does not page through the blobs.
CREATE TABLE submap_blobs (
  submap INTEGER PRIMARY KEY REFERENCES submaps (key) ON DELETE CASCADE,
  data BLOB NOT NULL
) STRICT;

-- Bounds in the odom frame of the submap's session. Absent for submaps without points. Coordinates
-- are float32, rounded outwards.
CREATE VIRTUAL TABLE submap_bounds USING rtree (
  submap, min_x, max_x, min_y, max_y, min_z, max_z
);
CREATE TRIGGER submap_bounds_follow AFTER DELETE ON submaps BEGIN
  DELETE FROM submap_bounds WHERE submap = OLD.key;
END;

-- What matching computed of a submap and wants back: opaque bytes under a kind.
CREATE TABLE features (
  key INTEGER PRIMARY KEY,
  submap INTEGER NOT NULL REFERENCES submaps (key) ON DELETE CASCADE,
  kind TEXT NOT NULL,
  crc32c INTEGER NOT NULL,
  data BLOB NOT NULL,
  UNIQUE (submap, kind)
) STRICT;

-- The last result for each pair of sessions, a before b in the order of their ids.
CREATE TABLE matches (
  a INTEGER NOT NULL REFERENCES sessions (key) ON DELETE CASCADE,
  b INTEGER NOT NULL REFERENCES sessions (key) ON DELETE CASCADE,
  T_a_b BLOB NOT NULL,
  state TEXT NOT NULL CHECK (state IN ('ACCEPTED', 'REJECTED', 'AMBIGUOUS', 'NOT_YET')),
  reason TEXT NOT NULL,
  detail TEXT NOT NULL,
  confidence REAL,  -- NULL stands for NaN, here and below.
  overlap REAL,
  inliers INTEGER NOT NULL,
  residual_m REAL,
  free_space REAL,
  comparisons INTEGER NOT NULL,
  runner_up REAL,
  matcher TEXT NOT NULL,
  submaps_a INTEGER NOT NULL,
  submaps_b INTEGER NOT NULL,
  computed_ns INTEGER NOT NULL,
  PRIMARY KEY (a, b)
) STRICT, WITHOUT ROWID;
CREATE INDEX matches_by_b ON matches (b);

-- Computing time of a match, stage by stage in order.
CREATE TABLE match_stages (
  a INTEGER NOT NULL,
  b INTEGER NOT NULL,
  position INTEGER NOT NULL,
  stage TEXT NOT NULL,
  ms REAL,
  PRIMARY KEY (a, b, position),
  FOREIGN KEY (a, b) REFERENCES matches (a, b) ON DELETE CASCADE
) STRICT, WITHOUT ROWID;

-- The newest thousand revisions. Sessions are named, not referred to: history outlives them.
CREATE TABLE revisions (
  revision INTEGER PRIMARY KEY,
  stamp_ns INTEGER NOT NULL,
  cause TEXT NOT NULL
) STRICT;
CREATE TABLE placements (
  revision INTEGER NOT NULL REFERENCES revisions (revision) ON DELETE CASCADE,
  session TEXT NOT NULL,
  component INTEGER NOT NULL,
  reference TEXT NOT NULL,
  T_map_odom BLOB NOT NULL,
  PRIMARY KEY (revision, session)
) STRICT, WITHOUT ROWID;
