-- A hash over keyframes and points, which tells submaps apart that cover the same scans. NULL for
-- those stored before, until they are read.
ALTER TABLE submaps ADD COLUMN content INTEGER;
