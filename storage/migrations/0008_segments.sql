-- A robot that stays lost goes on in a new segment of its session: a session of its own, which
-- refers to the one that the robot opened and goes with it.
ALTER TABLE sessions ADD COLUMN segment INTEGER NOT NULL DEFAULT 1;
ALTER TABLE sessions ADD COLUMN first_segment INTEGER REFERENCES sessions (key) ON DELETE CASCADE;
CREATE INDEX sessions_by_first_segment ON sessions (first_segment);

-- What became of the scans of all segments: of a finished session, in the row of its first segment.
ALTER TABLE sessions ADD COLUMN scans_ok INTEGER NOT NULL DEFAULT 0;
ALTER TABLE sessions ADD COLUMN scans_degenerate INTEGER NOT NULL DEFAULT 0;
ALTER TABLE sessions ADD COLUMN scans_lost INTEGER NOT NULL DEFAULT 0;
ALTER TABLE sessions ADD COLUMN scans_rejected INTEGER NOT NULL DEFAULT 0;
