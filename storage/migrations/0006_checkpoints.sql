-- What the worker of an active session knew once scan `sequence` was dealt with: opaque bytes.
CREATE TABLE checkpoints (
  session INTEGER PRIMARY KEY REFERENCES sessions (key) ON DELETE CASCADE,
  sequence INTEGER NOT NULL,
  durable_sequence INTEGER NOT NULL,  -- Needs no `data` to be safe.
  crc32c INTEGER NOT NULL,            -- Of `data`.
  data BLOB NOT NULL
) STRICT;
