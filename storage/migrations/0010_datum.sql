-- Where on the Earth the frame of the anchors lies; one row, or none.
CREATE TABLE datum (
  id INTEGER PRIMARY KEY CHECK (id = 1),
  latitude_deg REAL NOT NULL,
  longitude_deg REAL NOT NULL,
  altitude_m REAL NOT NULL,
  heading_deg REAL NOT NULL,
  given_ns INTEGER NOT NULL
) STRICT;
