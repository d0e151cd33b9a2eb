"""A robot that only asks where it is, in the map that another one made; of a server that dies."""
import unittest

import numpy as np

import isthmus
from isthmus import LocalisationState
from servers import Server, scans


class LocaliseTest(unittest.TestCase):
    def setUp(self) -> None:
        self.server = self.enterContext(Server())
        self.client = self.enterContext(isthmus.connect(self.server.address))

    def test_without_a_map_it_says_so(self) -> None:
        with self.client.open_localisation("vlp16") as localisation:
            with self.assertRaisesRegex(isthmus.FailedPrecondition, "no map"):
                localisation.locate(scans(0)[0].stamp_ns, scans(0)[0].points)

    def test_a_robot_is_found_where_it_is_and_the_map_stays(self) -> None:
        drive = list(scans(0))
        self.client.push("alice", drive, sensor="vlp16")
        self.client.wait("settled")  # Placed.
        stamps, poses = self.client.trajectory("alice", "odom")
        known = {int(stamp): pose for stamp, pose in zip(stamps, poses)}
        located = 0
        for stamp, place in self.client.localise(drive[3:], "vlp16"):
            self.assertEqual(place.rejected, "")
            if place.state != LocalisationState.LOCATED:
                continue
            located += 1
            assert place.T_map_sensor is not None and place.covariance is not None
            apart = place.T_map_sensor.matrix()[:3, 3] - known[stamp][:3, 3]
            self.assertLess(np.linalg.norm(apart), 0.1)
            self.assertEqual(place.covariance.shape, (6, 6))
        self.assertGreater(located, 5)
        self.assertEqual(len(self.client.list_sessions()), 1)

    def test_a_robot_is_listed_while_it_is_localised(self) -> None:
        drive = list(scans(0))
        self.client.push("alice", drive, sensor="vlp16")
        self.assertEqual(self.client.get_status().localising, ())
        with self.client.open_localisation("vlp16", robot="guest") as localisation:
            located = localisation.locate(drive[0].stamp_ns, drive[0].points)
            (place,) = self.client.get_status().localising
            self.assertEqual((place.robot, place.session), ("guest", ""))
            assert place.localising is not None
            self.assertEqual(place.localising.state, located.state)
            self.assertEqual(place.localising.scans, 1)
            self.assertGreaterEqual(place.localising.received_ns, place.localising.since_ns)

    def test_what_is_wrong_is_said(self) -> None:
        self.client.push("alice", scans(0), sensor="vlp16")
        first = scans(0)[0]
        with self.client.open_localisation("sonar") as localisation:
            self.assertRaises(isthmus.InvalidArgument, localisation.locate, first.stamp_ns,
                              first.points)
        with self.client.open_localisation("vlp16", in_map_of="bob") as localisation:
            self.assertRaises(isthmus.NotFound, localisation.locate, first.stamp_ns, first.points)

    def test_a_server_that_was_killed_is_asked_again(self) -> None:
        drive = list(scans(0))
        self.client.push("alice", drive, sensor="vlp16")
        with self.client.open_localisation("vlp16") as localisation:
            localisation.locate(drive[0].stamp_ns, drive[0].points)
            self.server.kill()
            self.server.start()
            place = localisation.locate(drive[1].stamp_ns, drive[1].points)
            self.assertEqual(place.rejected, "")


if __name__ == "__main__":
    unittest.main()
