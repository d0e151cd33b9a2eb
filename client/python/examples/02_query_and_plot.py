#!/usr/bin/python3
"""Draws the merged map and the robots' trajectories from above.

    02_query_and_plot.py ADDRESS OUTPUT.png
"""
import sys

import matplotlib

matplotlib.use("Agg")  # No screen is needed.
import matplotlib.pyplot as plt
import numpy as np

import isthmus


def draw_map(axes: plt.Axes, client: isthmus.Client) -> None:
    """Walls: one point per 10 cm of what each robot saw between its knees and its head."""
    # The map frame has the sensor of its reference at its origin: z is relative to that.
    cloud = client.query(box=((-1e4, -1e4, -0.3), (1e4, 1e4, 1.5)), resolution=0.1)
    for k, robot in enumerate(sorted(set(cloud["robot"]))):
        seen = cloud[cloud["robot"] == robot]
        axes.scatter(seen["x"], seen["y"], s=0.2, color=f"C{k}", alpha=0.5, linewidths=0)


def draw_trajectories(axes: plt.Axes, client: isthmus.Client) -> None:
    for k, robot in enumerate(sorted(client.robots())):
        try:
            trajectory = client.get_trajectory(robot)
        except isthmus.FailedPrecondition:
            continue  # It is not placed yet.
        if trajectory.component == 0:  # The others lie in frames of their own.
            places = trajectory.poses[:, :3, 3]  # T_map_sensor.
            axes.plot(places[:, 0], places[:, 1], color=f"C{k}", label=robot)


def main(address: str, output: str) -> None:
    figure, axes = plt.subplots(figsize=(8, 8))
    with isthmus.connect(address) as client:
        info = client.wait("settled")
        draw_map(axes, client)
        draw_trajectories(axes, client)
    axes.set(xlabel="x [m]", ylabel="y [m]", title=f"revision {info.revision}")
    axes.set_aspect("equal")
    if axes.get_legend_handles_labels()[0]:
        axes.legend()
    figure.savefig(output, dpi=120)
    spread = np.ptp(axes.dataLim.get_points(), axis=0)
    print(f"{output}: {spread[0]:.0f} x {spread[1]:.0f} m")


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
