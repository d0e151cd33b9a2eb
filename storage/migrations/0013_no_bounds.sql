-- Boxes of submaps, which no reader asked for: `submaps` has the bounds.
DROP TRIGGER submap_bounds_follow;
DROP TABLE submap_bounds;
