-- Which odometry a session asked for: "continuous", "floam" or "aloam"; empty: the server's own.
ALTER TABLE sessions ADD COLUMN odometry TEXT NOT NULL DEFAULT '';
