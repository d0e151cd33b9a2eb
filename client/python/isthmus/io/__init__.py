"""Files that robots' data comes in, and goes out as: PCD, KITTI's scans, TUM trajectories.

All functions raise `InvalidArgument`, naming the file and what is wrong with it, for contents that
are not what they should be, and `OSError` where a file cannot be read or written; that of writing
is an `isthmus.Error` too. What is written replaces the file only when it is whole.
"""
from isthmus.io.kitti import read_kitti_bin
from isthmus.io.pcd import Pcd, read_pcd, write_pcd
from isthmus.io.tum import read_tum, write_tum

__all__ = ["Pcd", "read_kitti_bin", "read_pcd", "read_tum", "write_pcd", "write_tum"]
