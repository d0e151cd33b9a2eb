#!/usr/bin/python3
"""Draws the figures of a folder: what figures.json says, each as SVG and as PNG.

Usage: python3 figures.py [FOLDER]     # of this file, unless another is named
Change figures.json or this script and run it again. Needs Matplotlib (Debian: python3-matplotlib).
"""
import json
import math
import pathlib
import sys

try:
    import matplotlib
    from matplotlib.figure import Figure
except ImportError as error:
    print(error, file=sys.stderr)
    sys.exit(3)

# Told apart by colour-blind readers too (Okabe and Ito), dark enough on white, light enough on black.
COLORS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#b8860b", "#56b4e9"]
DASHES = ["-", "--", "-.", ":"]
INK = "#202428"    # Pages put their own colour of text in its place.
FAINT = "#808488"  # On white and on black.
WIDE = 8.0         # Inches.
MOST_STEPS = 600   # A figure over scans has no more; longer series become means of several scans.

STYLE = {
    "font.family": "sans-serif", "font.sans-serif": ["DejaVu Sans", "Arial", "Helvetica"],
    "font.size": 10, "axes.titlesize": 11, "axes.labelsize": 10, "legend.fontsize": 9,
    "svg.fonttype": "none", "svg.hashsalt": "isthmus", "text.parse_math": False,
    "text.color": INK, "axes.labelcolor": INK, "axes.edgecolor": FAINT, "axes.titlecolor": INK,
    "xtick.color": FAINT, "ytick.color": FAINT, "xtick.labelcolor": INK, "ytick.labelcolor": INK,
    "axes.spines.top": False, "axes.spines.right": False, "axes.grid": True,
    "grid.color": FAINT, "grid.alpha": 0.25, "axes.axisbelow": True, "axes.facecolor": "none",
    "lines.linewidth": 1.6, "legend.frameon": False, "figure.facecolor": "#ffffff",
    "axes.titlelocation": "left",
}


def label(text):
    """A name from outside, as a legend takes it: one that begins with _ would be left out."""
    text = "".join(c if c.isprintable() else " " for c in text)
    text = text if len(text) <= 40 else text[:37] + "..."
    return "\u200a" + text if text.startswith("_") else text


def style_of(index):
    return {"color": COLORS[index % len(COLORS)],
            "linestyle": DASHES[index // len(COLORS) % len(DASHES)]}


def legend_above(axes):
    """A legend above the axes, where it hides nothing; as many columns as its words allow."""
    handles, labels = axes.get_legend_handles_labels()
    if not handles:
        return
    columns = min(len(labels), max(1, 100 // (max(map(len, labels)) + 8)))
    rows = math.ceil(len(labels) / columns)
    columns = math.ceil(len(labels) / rows)
    # Matplotlib fills column by column; people read row by row.
    order = [row * columns + column for column in range(columns) for row in range(rows)
             if row * columns + column < len(labels)]
    axes.legend([handles[i] for i in order], [labels[i] for i in order], loc="lower left",
                ncol=columns, borderaxespad=0, bbox_to_anchor=(0, 1.01), handlelength=2.2,
                columnspacing=1.6)


def plan_figure(points, extra=0.0):
    """A figure for a plan of that extent, equal axes: wide ones flat, tall ones narrow."""
    xs, ys = [p for x, _ in points for p in x], [p for _, y in points for p in y]
    width = max(max(xs) - min(xs), 1e-3)
    height = max(max(ys) - min(ys), 1e-3)
    tall = min(8.5, max(3.0, WIDE * height / width))
    figure = Figure(figsize=(WIDE, tall + 0.9 + extra), constrained_layout=True)
    axes = figure.add_subplot()
    axes.set_aspect("equal", adjustable="datalim")
    return figure, axes


def mark_ends(axes, x, y, color):
    axes.plot(x[:1], y[:1], "o", color=color, markersize=9, markerfacecolor="none",
              markeredgewidth=2)
    axes.plot(x[-1:], y[-1:], "s", color=color, markersize=6)


def draw_trajectories(data):
    series = data["series"]
    figure, axes = plan_figure([s["truth"] for s in series] + [s["estimate"] for s in series])
    for i, s in enumerate(series):
        if s["truth_drawn"]:
            axes.plot(*s["truth"], color=FAINT, linewidth=4.5, alpha=0.5,
                      label="truth" if i == 0 else None, solid_capstyle="round")
    for i, s in enumerate(series):
        axes.plot(*s["estimate"], label=label(s["name"]), linewidth=1.3, **style_of(i))
        mark_ends(axes, *s["estimate"], style_of(i)["color"])
    axes.plot([], [], "o", color=INK, markerfacecolor="none", markeredgewidth=2, label="start")
    axes.plot([], [], "s", color=INK, label="end")
    axes.set_xlabel(data["axes"][0] + " [m]")
    axes.set_ylabel(data["axes"][1] + " [m]")
    legend_above(axes)
    return figure


def draw_error(data):
    figure = Figure(figsize=(WIDE, 5), constrained_layout=True)
    top, bottom = figure.subplots(2, 1, sharex=True)
    for i, s in enumerate(data["series"]):
        top.plot(s["way_m"], s["error_m"], label=label(s["name"]), linewidth=1.1, **style_of(i))
        bottom.plot(s["way_m"], s["error_deg"], linewidth=1.1, **style_of(i))
    top.set_ylabel("position error [m]")
    bottom.set_ylabel("rotation error [deg]")
    bottom.set_xlabel("distance driven [m]")
    for axes in (top, bottom):
        axes.set_ylim(bottom=0)
        axes.margins(x=0.01)
    legend_above(top)
    return figure


def draw_drift(data):
    series = [s for s in data["series"] if s["lengths"]]
    lengths = sorted({l["length_m"] for s in series for l in s["lengths"]})
    figure = Figure(figsize=(WIDE, 5), constrained_layout=True)
    panels = figure.subplots(2, 1, sharex=True)
    room = 0.8 / len(series)
    for key, axes in zip(("percent", "deg_per_100m"), panels):
        for i, s in enumerate(series):
            color = style_of(i)["color"]
            at = [lengths.index(l["length_m"]) - 0.4 + room * (i + 0.5) for l in s["lengths"]]
            boxes = axes.boxplot(
                [l[key] for l in s["lengths"]], positions=at, widths=0.8 * room, whis=(5, 95),
                showfliers=False, patch_artist=True, manage_ticks=False,
                medianprops={"color": color, "linewidth": 2.2}, whiskerprops={"color": color},
                capprops={"color": color}, boxprops={"edgecolor": color, "linewidth": 1.2})
            for box in boxes["boxes"]:
                box.set_facecolor(color + "40")
            axes.plot([], [], color=color, linewidth=6, label=label(s["name"]))
        axes.set_ylim(bottom=0)
        axes.grid(axis="x", visible=False)
    panels[0].set_ylabel("translation [%]")
    panels[1].set_ylabel("rotation [deg/100 m]")
    panels[1].set_xticks(range(len(lengths)), [f"{l:g}" for l in lengths])
    panels[1].set_xlim(-0.6, len(lengths) - 0.4)
    panels[1].set_xlabel("length of segment [m]    (box: quartiles and median, whiskers: 5 and 95 %)")
    legend_above(panels[0])
    return figure


def thinned(values, count):
    """Means of as many equal parts as there may be."""
    step = math.ceil(len(values) / count)
    parts = [values[i:i + step] for i in range(0, len(values), step)]
    return [sum(part) / len(part) for part in parts]


def draw_timing(data):
    series = data["series"]
    figure = Figure(figsize=(WIDE, 0.8 + 2.3 * len(series)), constrained_layout=True)
    rows = figure.subplots(len(series), 1, squeeze=False, sharex=True)
    for axes, s in zip(rows[:, 0], series):
        scans = thinned(s["scan"], MOST_STEPS)
        below = [0.0] * len(scans)
        for i, stage in enumerate(s["stages"]):
            above = [a + b for a, b in zip(below, thinned(stage["ms"], MOST_STEPS))]
            axes.fill_between(scans, below, above, color=COLORS[i % len(COLORS)], linewidth=0,
                              alpha=0.85, label=label(stage["name"]))
            below = above
        bad = [scan for scan, state in zip(s["scan"], s["tracking"]) if state == "lost"]
        if bad:
            axes.plot(bad, [0] * len(bad), "|", color=INK, markersize=9, label="lost")
        total = sorted(s["total_ms"])
        title = f"{label(s['name'])}: {sum(total) / len(total):.1f} ms per scan, {total[-1]:.1f} at most"
        # One slow scan, the first as a rule, must not flatten all others.
        top = max(1.5 * total[int(0.98 * (len(total) - 1))], 1e-3)
        beyond = sum(1 for ms in total if ms > top)
        axes.set_ylim(0, top if beyond else None)
        if beyond:
            title += f" ({beyond} beyond the axis)"
        axes.set_title(title, loc="right", fontsize=9)
        axes.set_ylabel("ms per scan")
        axes.margins(x=0.01)
    step = math.ceil(max(len(s["scan"]) for s in series) / MOST_STEPS)
    rows[-1, 0].set_xlabel("scan" + (f"    (means of {step})" if step > 1 else ""))
    legend_above(rows[0, 0])
    return figure


def draw_graph(data):
    """Sessions on a circle, map by map, and the matches between them."""
    nodes, edges = data["nodes"], data["edges"]
    count = max(len(nodes), 1)
    side = min(11.0, max(5.0, 0.42 * count + 3.2))
    figure = Figure(figsize=(max(WIDE, side), side), constrained_layout=True)
    axes = figure.add_subplot()
    axes.axis("off")
    # One pair lies side by side, so that its label is read along the line.
    at = {n["name"]: (math.cos(math.pi + 2 * math.pi * i / count),
                      math.sin(math.pi + 2 * math.pi * i / count)) for i, n in enumerate(nodes)}
    kinds = {"tree": ("-", INK, 2.6, "carries the map"), "accepted": ("--", INK, 1.6, "accepted"),
             "open": (":", FAINT, 1.6, "open"), "rejected": ((0, (1, 4)), "#d55e00", 1.6, "rejected")}
    for kind, (dashes, color, width, text) in kinds.items():
        drawn = [e for e in edges if e["kind"] == kind]
        for i, e in enumerate(drawn):
            (x0, y0), (x1, y1) = at[e["a"]], at[e["b"]]
            axes.plot([x0, x1], [y0, y1], linestyle=dashes, color=color, linewidth=width, zorder=1,
                      label=text if i == 0 else None)
            if len(edges) > 12 and kind in ("open", "rejected"):
                continue  # Their reasons are in the table; here they would hide each other.
            share = 0.5 if len(edges) <= 3 else 0.42 if i % 2 else 0.58
            axes.annotate(e["label"], (x0 + share * (x1 - x0), y0 + share * (y1 - y0)),
                          ha="center", va="center", fontsize=8, color=INK, zorder=3,
                          bbox={"boxstyle": "round,pad=0.25", "fc": "#fefefe", "ec": "none"})
    for n in nodes:
        color = COLORS[n["component"] % len(COLORS)]
        axes.plot(*at[n["name"]], "o", markersize=13, color=color, zorder=2)
        x, y = at[n["name"]]
        axes.annotate(label(n["name"]), (x, y), (14 * x, 14 * y), textcoords="offset points",
                      ha="left" if x > 0.2 else "right" if x < -0.2 else "center",
                      va="bottom" if y > 0.2 else "top" if y < -0.2 else "center", zorder=4)
    axes.set_xlim(-1.75, 1.75)
    axes.set_ylim(-1.25, 1.25) if count > 2 else axes.set_ylim(-0.3, 0.3)
    if count <= 2:
        figure.set_size_inches(WIDE, 2.2)
    legend_above(axes)
    return figure


def draw_map(data):
    from matplotlib.image import imread  # Needs Pillow for other files than PNG only.
    x0, x1, y0, y1 = data["extent"]
    figure, axes = plan_figure([([x0, x1], [y0, y1])])
    axes.imshow(imread(data["image"]), extent=(x0, x1, y0, y1), interpolation="nearest", zorder=0)
    axes.set_aspect("equal", adjustable="box")
    axes.grid(False)
    for s in data["series"]:
        x, y = s["way"]
        if x:
            axes.plot(x, y, color="#fefefe", linewidth=4)
            axes.plot(x, y, color=s["color"], linewidth=1.8)
            mark_ends(axes, x, y, s["color"])
        axes.plot([], [], color=s["color"], linewidth=4, label=label(s["name"]))
    axes.plot([], [], "o", color=INK, markerfacecolor="none", markeredgewidth=2, label="start")
    axes.plot([], [], "s", color=INK, label="end")
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")
    legend_above(axes)
    return figure


def main():
    folder = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else __file__).resolve()
    folder = folder if folder.is_dir() else folder.parent
    document = json.loads((folder / "figures.json").read_text(encoding="utf-8"))
    matplotlib.rcdefaults()
    matplotlib.rcParams.update(STYLE)
    for figure in document["figures"]:
        if figure["kind"] == "map":
            figure["image"] = str(folder / figure["image"])
        drawn = globals()["draw_" + figure["kind"]](figure)
        for kind in ("svg", "png"):
            metadata = {"Title": figure["title"], "Date": None} if kind == "svg" else None
            drawn.savefig(folder / f"{figure['file']}.{kind}", dpi=150, metadata=metadata,
                          bbox_inches="tight", pad_inches=0.1)


if __name__ == "__main__":
    main()
