-- What the odometry says of its drift since the submap before: 21 float64, the upper triangle row
-- by row of the covariance of a twist [rho; phi]; NULL: nothing.
ALTER TABLE submaps ADD COLUMN drift_covariance BLOB;

-- Finds the scans of a submap that is retired.
CREATE INDEX trajectory_by_submap ON trajectory (session, submap_index);

-- Places that a session came back to. `edges`: see "Edge blob" in docs/storage-format.md.
CREATE TABLE loops (
  id INTEGER PRIMARY KEY,
  session INTEGER NOT NULL REFERENCES sessions (key) ON DELETE CASCADE,
  submap_a INTEGER NOT NULL,
  submap_b INTEGER NOT NULL CHECK (submap_a < submap_b),
  T_a_b BLOB NOT NULL,
  confidence REAL,  -- NULL stands for NaN, here and below.
  overlap REAL,
  residual_m REAL,
  free_space REAL,
  comparisons INTEGER NOT NULL,
  source TEXT NOT NULL,
  detail TEXT NOT NULL,
  computed_ns INTEGER NOT NULL,
  edges BLOB NOT NULL,
  rejected INTEGER NOT NULL CHECK (rejected IN (0, 1)),
  note TEXT NOT NULL
) STRICT;
CREATE INDEX loops_by_session ON loops (session);

-- Submaps whose place is known from outside.
CREATE TABLE anchors (
  submap INTEGER PRIMARY KEY REFERENCES submaps (key) ON DELETE CASCADE,
  T_map_submap BLOB NOT NULL,
  sigma_xy_m REAL NOT NULL,  -- 0: not known, here and below.
  sigma_z_m REAL NOT NULL,
  sigma_deg REAL NOT NULL,
  note TEXT NOT NULL,
  given_ns INTEGER NOT NULL
) STRICT;

-- What made a revision, and how many submaps it placed, moved or took out. NULL in `added`: from
-- before submaps were placed one by one, so that its moves are not known.
ALTER TABLE revisions ADD COLUMN added INTEGER;
ALTER TABLE revisions ADD COLUMN moved INTEGER NOT NULL DEFAULT 0;
ALTER TABLE revisions ADD COLUMN removed INTEGER NOT NULL DEFAULT 0;
ALTER TABLE revisions ADD COLUMN largest_move_m REAL NOT NULL DEFAULT 0;
CREATE TABLE revision_matches (
  revision INTEGER NOT NULL REFERENCES revisions (revision) ON DELETE CASCADE,
  position INTEGER NOT NULL,
  a TEXT NOT NULL,
  b TEXT NOT NULL,
  PRIMARY KEY (revision, position)
) STRICT, WITHOUT ROWID;
CREATE TABLE revision_loops (
  revision INTEGER NOT NULL REFERENCES revisions (revision) ON DELETE CASCADE,
  position INTEGER NOT NULL,
  loop INTEGER NOT NULL,
  PRIMARY KEY (revision, position)
) STRICT, WITHOUT ROWID;

-- What a revision did to each submap that it touched. NULL: it was not in the map before, or is not
-- afterwards. Named, not referred to, like all that is history.
CREATE TABLE submap_moves (
  revision INTEGER NOT NULL REFERENCES revisions (revision) ON DELETE CASCADE,
  session TEXT NOT NULL,
  submap_index INTEGER NOT NULL,
  T_before BLOB,
  frame_before TEXT NOT NULL,
  T_after BLOB,
  frame_after TEXT NOT NULL,
  PRIMARY KEY (revision, session, submap_index)
) STRICT, WITHOUT ROWID;

-- Where every submap lies as of the latest revision, in the frame of its session's placement: what
-- all moves together come to.
CREATE TABLE placed_submaps (
  session TEXT NOT NULL,
  submap_index INTEGER NOT NULL,
  T_map_submap BLOB NOT NULL,
  PRIMARY KEY (session, submap_index)
) STRICT, WITHOUT ROWID;

-- From here on only the latest revision's placements are kept: earlier ones follow from the moves.
DELETE FROM placements WHERE revision < (SELECT max(revision) FROM revisions);
