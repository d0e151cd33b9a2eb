-- The progress of matching with a session: a server that starts goes on there.
CREATE TABLE matching_progress (
  session INTEGER PRIMARY KEY REFERENCES sessions (key) ON DELETE CASCADE,
  next_for_loops INTEGER NOT NULL,  -- Submaps before this index were searched for loops.
  -- The index that the session's next submap had when its partners were last chosen; 0: never.
  next_at_choice INTEGER NOT NULL,
  -- Pairs of the session that may be tried since then: all, those that are searched beyond a first
  -- look, and those within its component.
  max_pairs INTEGER NOT NULL,
  max_searched INTEGER NOT NULL,
  max_joined INTEGER NOT NULL
) STRICT;

-- Until now the submap that was searched last had it, as a row of `features`, and so had the one
-- after which partners were chosen, as "PAIRS SEARCHED JOINED"; at first without the last, of which
-- there are 10 at least.
INSERT INTO matching_progress
SELECT session, max(CASE kind WHEN 'loops-v1' THEN submap_index + 1 ELSE 0 END), 0, 0, 0, 0
FROM features JOIN submaps ON submaps.key = features.submap
WHERE kind IN ('loops-v1', 'partners-v1') GROUP BY session;

-- The bare column is that of the row with the greatest index.
UPDATE matching_progress SET next_at_choice = next, max_pairs = CAST(pairs AS INTEGER),
  max_searched = CAST(searched AS INTEGER),
  max_joined = CASE instr(searched, ' ') WHEN 0 THEN 10
    ELSE CAST(substr(searched, instr(searched, ' ') + 1) AS INTEGER) END
FROM (
  SELECT of, next, words AS pairs, substr(words, instr(words, ' ') + 1) AS searched FROM (
    SELECT session AS of, max(submap_index) + 1 AS next, CAST(data AS TEXT) AS words
    FROM features JOIN submaps ON submaps.key = features.submap
    WHERE kind = 'partners-v1' AND CAST(data AS TEXT) GLOB '[0-9]* [0-9]*'
      AND CAST(data AS TEXT) NOT GLOB '*[^0-9 ]*'
    GROUP BY session)
) WHERE session = of;

DELETE FROM features WHERE kind IN ('loops-v1', 'partners-v1');
