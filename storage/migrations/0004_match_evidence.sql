-- More of what a match rests on. Of a match stored before this, -1 as of what no stage computed.
ALTER TABLE matches ADD COLUMN inlier_ratio REAL DEFAULT -1;
ALTER TABLE matches ADD COLUMN shared_area_m2 REAL DEFAULT -1;
ALTER TABLE matches ADD COLUMN hold REAL DEFAULT -1;
ALTER TABLE matches ADD COLUMN strain REAL DEFAULT -1;
ALTER TABLE matches ADD COLUMN candidates INTEGER NOT NULL DEFAULT 0;
-- How submaps of a lie on submaps of b, see "Edges" in docs/storage-format.md; NULL: none.
ALTER TABLE matches ADD COLUMN edges BLOB;
