"""How dense balls lie that were dropped into a silo with four walls and a floor: the porosity along its height.

The porosity of a ball's cell is what the ball leaves of it: it tells where there is room ball by ball, and cells at the
walls are larger than in the middle. That of horizontal cuts shows the layers in which balls lie on the floor.

porosity_of_a_packing.py [porosity.png]
"""
import sys

import numpy as np

import vcell

radius, width, count = 0.5, 5.0, 300


def settled_balls(seed=3):
    """Balls dropped one after the other, each to about the lowest place that it can reach from above: shape (count, 3)."""
    rng = np.random.default_rng(seed)
    side = np.linspace(radius, width - radius, 161)
    places = np.stack(np.meshgrid(side, side), axis=-1)
    rest = np.full(places.shape[:2], radius)  # the height at which a ball that comes down there touches something
    balls = []
    for _ in range(count):
        lowest = np.unravel_index(np.argmin(rest + rng.exponential(0.05, rest.shape)), rest.shape)
        balls.append((*places[lowest], rest[lowest]))
        squared = (2 * radius) ** 2 - ((places - balls[-1][:2]) ** 2).sum(axis=-1)
        rest = np.maximum(rest, np.where(squared > 0, balls[-1][2] + np.sqrt(np.maximum(squared, 0)), 0))
    return np.array(balls)


def porosity_of_cuts(x, heights):
    """The part of each horizontal cut that is in no ball."""
    squared = np.maximum(0, radius ** 2 - (heights[:, None] - x[None, :, 2]) ** 2)
    return 1 - np.pi * squared.sum(axis=1) / width ** 2


def draw(x, porosity, heights, cuts, path):
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(8, 5))
    axes.plot(heights, cuts, color="tab:blue", label="horizontal cuts")
    marks = axes.scatter(x[:, 2], porosity, s=10, c=np.minimum(x[:, :2], width - x[:, :2]).min(axis=1), cmap="copper",
                         label="Voronoi cells of balls")
    figure.colorbar(marks, label="distance from the nearest wall")
    axes.set(xlabel="height above the floor", ylabel="porosity", ylim=(0, 1), xlim=(0, heights[-1]),
             title="balls of radius 0.5 between walls 5 apart")
    axes.legend()
    figure.tight_layout()
    figure.savefig(path, dpi=100)


def main():
    x = settled_balls()
    top = np.quantile(x[:, 2], 0.9)  # above, cells reach up to the box
    box = [(0, 0, 0), (width, width, x[:, 2].max() + radius)]
    diagram = vcell.diagram(vcell.DiagramScene(np.column_stack([x, np.full(count, radius)]), box))
    assert diagram.filled_volume().fills
    ball = 4 / 3 * np.pi * radius ** 3
    porosity = 1 - ball / diagram.volume
    heights = np.linspace(0, top, 400)
    cuts = porosity_of_cuts(x, heights)
    inside = (x[:, 2] > 2 * radius) & (x[:, 2] < top - 2 * radius)
    at_wall = np.minimum(x[:, :2], width - x[:, :2]).min(axis=1) < 1.2 * radius
    print(f"cells in the middle: porosity {np.mean(porosity[inside & ~at_wall]):.3f}, at the walls "
          f"{np.mean(porosity[inside & at_wall]):.3f}; cuts: {np.mean(cuts):.3f} in the mean, "
          f"{cuts.min():.3f} at least")
    if len(sys.argv) > 1:
        draw(x, porosity, heights, cuts, sys.argv[1])


if __name__ == "__main__":
    main()
