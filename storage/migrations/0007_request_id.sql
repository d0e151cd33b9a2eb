-- What the client asked for the session with, so that asking twice opens one; empty: nothing.
ALTER TABLE sessions ADD COLUMN request_id TEXT NOT NULL DEFAULT '';
