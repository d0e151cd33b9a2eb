-- The progress of matching with a session: a server that starts goes on there.
CREATE TABLE matching_progress (
  session BIGINT PRIMARY KEY REFERENCES sessions (key) ON DELETE CASCADE,
  next_for_loops BIGINT NOT NULL,  -- Submaps before this index were searched for loops.
  -- The index that the session's next submap had when its partners were last chosen; 0: never.
  next_at_choice BIGINT NOT NULL,
  -- Pairs of the session that may be tried since then: all, those that are searched beyond a first
  -- look, and those within its component.
  max_pairs BIGINT NOT NULL,
  max_searched BIGINT NOT NULL,
  max_joined BIGINT NOT NULL
);

-- Until now the submap that was searched last had it, as a row of `features`, and so had the one
-- after which partners were chosen, as "PAIRS SEARCHED JOINED"; at first without the last, of which
-- there are 10 at least.
INSERT INTO matching_progress
SELECT session, max(CASE kind WHEN 'loops-v1' THEN submap_index + 1 ELSE 0 END), 0, 0, 0, 0
FROM features JOIN submaps ON submaps.key = features.submap
WHERE kind IN ('loops-v1', 'partners-v1') GROUP BY session;

UPDATE matching_progress SET next_at_choice = next,
  max_pairs = split_part(words, ' ', 1)::bigint,
  max_searched = split_part(words, ' ', 2)::bigint,
  max_joined = coalesce(nullif(split_part(words, ' ', 3), ''), '10')::bigint
FROM (
  SELECT DISTINCT ON (session) session AS of, submap_index + 1 AS next,
    encode(data, 'escape') AS words
  FROM features JOIN submaps ON submaps.key = features.submap
  WHERE kind = 'partners-v1' AND encode(data, 'escape') ~ '^[0-9]{1,9} [0-9]{1,9}( [0-9]{1,9})?$'
  ORDER BY session, submap_index DESC
) AS chosen WHERE session = of;

DELETE FROM features WHERE kind IN ('loops-v1', 'partners-v1');
