-- What a person said of a pair of sessions, a before b in the order of their ids. Apart from
-- `matches`, which are computed anew again and again.
CREATE TABLE verdicts (
  a INTEGER NOT NULL REFERENCES sessions (key) ON DELETE CASCADE,
  b INTEGER NOT NULL REFERENCES sessions (key) ON DELETE CASCADE,
  ruling TEXT NOT NULL CHECK (ruling IN ('ACCEPT', 'REJECT', 'SET')),
  T_a_b BLOB NOT NULL,
  note TEXT NOT NULL,
  given_ns INTEGER NOT NULL,
  PRIMARY KEY (a, b)
) STRICT, WITHOUT ROWID;
CREATE INDEX verdicts_by_b ON verdicts (b);
