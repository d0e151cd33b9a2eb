-- The event log: what happened at the site, the newest 100,000 events. Numbers count from 1 and have
-- no gaps. `who` is the name of a token, `peer` an address; an empty text stands for none.
CREATE TABLE events (
  number INTEGER PRIMARY KEY,
  time_ns INTEGER NOT NULL,
  kind TEXT NOT NULL,
  who TEXT NOT NULL,
  peer TEXT NOT NULL,
  request_id TEXT NOT NULL,
  robot TEXT NOT NULL,
  session TEXT NOT NULL,
  text TEXT NOT NULL
) STRICT;
