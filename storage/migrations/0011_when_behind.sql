-- What happens to scans that come faster than the server deals with them: 0 waits, 1 keeps the
-- newest. And how many were skipped for that.
ALTER TABLE sessions ADD COLUMN when_behind INTEGER NOT NULL DEFAULT 0;
ALTER TABLE sessions ADD COLUMN scans_skipped INTEGER NOT NULL DEFAULT 0;
