"""Poses are what matrices are, and refuse what is none."""
import math
import unittest

import numpy as np

from isthmus import InvalidArgument, Pose
from isthmus.pose import matrices


def some_poses(count: int = 50) -> list:
    random = np.random.default_rng(3)
    return [Pose(random.normal(size=3) * 10, random.normal(size=4)) for _ in range(count)]


class PoseTest(unittest.TestCase):
    def test_composition_and_inverse_are_those_of_matrices(self) -> None:
        poses = some_poses()
        for a, b in zip(poses, poses[1:]):
            np.testing.assert_allclose((a @ b).matrix(), a.matrix() @ b.matrix(), atol=1e-12)
            np.testing.assert_allclose(a.inverse().matrix(), np.linalg.inv(a.matrix()), atol=1e-12)

    def test_a_matrix_gives_the_pose_back_however_it_is_turned(self) -> None:
        half_turns = [Pose((1, 2, 3), q) for q in np.eye(4)]
        for pose in some_poses() + half_turns:
            again = Pose.from_matrix(pose.matrix())
            np.testing.assert_allclose(again.matrix(), pose.matrix(), atol=1e-12)

    def test_points_go_from_source_to_target(self) -> None:
        T_map_odom = Pose.from_xyz_rpy(10, 0, 0, yaw=math.pi / 2)
        np.testing.assert_allclose(T_map_odom @ (1, 0, 0), (10, 1, 0), atol=1e-12)
        points = np.random.default_rng(1).normal(size=(7, 3))
        homogeneous = np.c_[points, np.ones(7)] @ T_map_odom.matrix().T
        np.testing.assert_allclose(T_map_odom @ points, homogeneous[:, :3], atol=1e-12)

    def test_roll_comes_first_and_yaw_last(self) -> None:
        turned = Pose.from_xyz_rpy(0, 0, 0, roll=math.pi / 2, yaw=math.pi / 2)
        np.testing.assert_allclose(turned @ (0, 1, 0), (0, 0, 1), atol=1e-12)
        self.assertAlmostEqual(Pose().angle_to(Pose.from_xyz_rpy(0, 0, 0, pitch=-0.3)), 0.3)

    def test_is_a_value(self) -> None:
        pose = Pose((1, 2, 3), (0, 0, 0, 2))
        self.assertEqual(pose, Pose((1, 2, 3)))
        self.assertEqual(len({pose, Pose((1, 2, 3))}), 1)
        self.assertNotEqual(pose, Pose())
        pose.translation[0] = 7  # Changes a copy.
        self.assertEqual(pose.translation[0], 1)
        with self.assertRaises(AttributeError):
            pose.translation = (0, 0, 0)  # type: ignore[misc,assignment]

    def test_refuses_what_is_no_pose(self) -> None:
        mirrored, stretched = np.diag([1.0, 1, -1, 1]), np.diag([2.0, 2, 2, 1])
        for matrix in (mirrored, stretched, np.eye(5), np.full((4, 4), math.nan)):
            with self.assertRaises(InvalidArgument):
                Pose.from_matrix(matrix)
        for translation, quaternion in (((1, 2), (0, 0, 0, 1)), ((1, 2, math.inf), (0, 0, 0, 1)),
                                        ((0, 0, 0), (0, 0, 0, 0)), ((0, 0, 0), (0, 0, 1))):
            with self.assertRaises(InvalidArgument):
                Pose(translation, quaternion)
        with self.assertRaises(ValueError):  # InvalidArgument is one.
            Pose() @ np.zeros((3, 2))

    def test_many_matrices_at_once_are_those_of_each(self) -> None:
        poses = some_poses()
        rows = np.array([[*pose.translation, *pose.quaternion] for pose in poses])
        np.testing.assert_allclose(matrices(rows), [pose.matrix() for pose in poses], atol=1e-12)
        self.assertEqual(matrices(np.zeros((0, 7))).shape, (0, 4, 4))


if __name__ == "__main__":
    unittest.main()
