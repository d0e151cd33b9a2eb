-- The other ways in which the maps of a match could lie on each other, the better ones first: of
-- several sessions together one of these may turn out to be right.
CREATE TABLE match_rivals (
  a INTEGER NOT NULL,
  b INTEGER NOT NULL,
  position INTEGER NOT NULL,
  T_a_b BLOB NOT NULL,
  state TEXT NOT NULL,
  reason TEXT NOT NULL,
  confidence REAL,
  matcher TEXT NOT NULL,
  overlap REAL,
  free_space REAL,
  comparisons INTEGER NOT NULL,
  shared_area_m2 REAL,
  -- As of matches; NULL: none.
  edges BLOB,
  PRIMARY KEY (a, b, position),
  FOREIGN KEY (a, b) REFERENCES matches (a, b) ON DELETE CASCADE
) STRICT, WITHOUT ROWID;
