-- Boxes of submaps, which no reader asked for: `submaps` has the bounds.
DROP TABLE submap_bounds;
