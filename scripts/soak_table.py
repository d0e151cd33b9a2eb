"""The table of a soak, and the rule of what is flat."""
import statistics
import threading

# Each figure of a later day may exceed that of the second, when caches are full and the first
# sessions were deleted, by this factor and this much: what a submap, a stream or a file of the
# archive more or less makes.
GROWTH = 1.25
ALLOWANCE = {"RSS, MB": 32, "files": 12, "threads": 6, "database, MB": 8, "disk, MB": 16}


class Sampler(threading.Thread):
    """Looks at the server's process and disk all day."""

    def __init__(self, server, period_s):
        super().__init__(name="sampler", daemon=True)
        self._server, self._period_s = server, period_s
        self._samples, self._is_over = [], threading.Event()

    def run(self):
        while not self._is_over.wait(self._period_s):
            try:
                self._samples.append(self._server.figures())
            except (OSError, KeyError):
                pass  # A file that went meanwhile; or the server, which others notice.

    def finish(self):
        self._is_over.set()

    def take_day(self):
        """The median of each figure since the last call; of what grows on the disk, the most."""
        samples, self._samples = self._samples, []
        if not samples:
            samples = [self._server.figures()]
        return {name: (max if "disk" in name or "data" in name else statistics.median)(
            one[name] for one in samples) for name in ALLOWANCE}


def growth(days):
    """What is not flat; the rule needs a day after the second."""
    return [f"day {number}: {name} {day[name]:.0f}, on day 2 {days[1][name]:.0f}"
            for number, day in enumerate(days[2:], 3) for name, allowed in ALLOWANCE.items()
            if day[name] > days[1][name] * GROWTH + allowed]


def markdown(days):
    names = list(days[0])
    lines = ["| " + " | ".join(names) + " |", "|" + "---|" * len(names)]
    for day in days:
        cells = [f"{value:.1f}" if isinstance(value, float) else str(value)
                 for value in day.values()]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)
