"""Cost-to-go of the base to a place: Dijkstra search on a grid."""

from __future__ import annotations

from math import inf
from typing import TYPE_CHECKING

import numpy as np

from config.arrays import Array, Indices, Mask

if TYPE_CHECKING:
    from scipy.sparse import csr_array

CELL = 0.10  # distance between the nodes of the graph [m]
_TIGHT = 30.0  # extra cost per metre where the base just fits; a fifth where it can nearly turn
_NEAR = 0.5  # extra cost per metre where the base can just turn ...
_OPEN = 0.30  # ... and none with this much more room [m]
_MOVES = [(1, 0), (0, 1), (1, 1), (1, -1), (2, 1), (1, 2), (2, -1), (1, -2)]
"""From a node to half of its neighbours; the others are opposite."""
_NEXT = 5  # number of nodes from a place to that ahead of it
_BORDER = 2  # width of the edge of the grid without nodes: the longest move


class Floor:
    """Graph of the places where the base fits.

    Args:
        low: x and y of the first node [m].
        room: (n, m) distances of the nodes to what is nearest [m].
        fits: distance from which the base fits, in one heading at least [m].
        turns: distance from which it can turn freely [m].
    """

    def __init__(self, low: Array, room: Array, fits: float, turns: float) -> None:
        self.low = low
        self.last = np.array(room.shape) - 1
        passes = room > fits
        tight = np.clip((turns - room) / (turns - fits), 0.0, 1.0)
        near = np.clip((turns + _OPEN - room) / _OPEN, 0.0, 1.0)
        cost = 1.0 + _NEAR * near + _TIGHT * np.where(tight > 0.0, 0.2 + 0.8 * tight, 0.0)
        self.passes = passes  # (n, m) the nodes where it fits
        self.graph = _graph(passes, cost)
        """Costs between neighbours [m]; nodes in the order of the flat grid."""

    def nodes_around(self, points: Array) -> tuple[Indices, Array]:
        """Indices (4, N) of the nodes around points (N, 2), and their distances (4, N) [m]."""
        scaled = (points - self.low) / CELL
        first = np.clip(np.floor(scaled), _BORDER, self.last - _BORDER - 1).astype(np.int64)
        corners = first + np.array([[[0, 0]], [[0, 1]], [[1, 0]], [[1, 1]]])
        away = np.linalg.norm((corners - scaled) * CELL, axis=2)
        return corners[..., 0] * (self.last[1] + 1) + corners[..., 1], away

    def nearest_node(self, point: tuple[float, float]) -> int:
        """The nearest node to a point x, y [m]; the base may stand where there is none."""
        nodes, away = self.nodes_around(np.array([point]))
        free = self.passes.ravel()[nodes[:, 0]]
        if free.any():
            return int(nodes[np.argmin(np.where(free, away[:, 0], inf)), 0])
        x, y = (self.low[k] + CELL * np.arange(self.last[k] + 1) - point[k] for k in (0, 1))
        return int(np.argmin(np.where(self.passes, np.hypot(x[:, None], y), inf)))


def _graph(passes: Mask, cost: Array) -> csr_array:
    """Costs between neighbouring nodes [m]."""
    n, m = passes.shape
    inner = np.zeros_like(passes)
    inner[_BORDER:-_BORDER, _BORDER:-_BORDER] = True
    here = np.flatnonzero(passes & inner)
    free, flat = passes.ravel(), cost.ravel()
    moves = np.array(_MOVES + [(-dx, -dy) for dx, dy in _MOVES])
    there = here[:, None] + moves @ [m, 1]
    # A knight's move passes between two nodes; other moves do not, and these are their ends.
    halves = np.stack([np.floor(moves / 2.0), np.ceil(moves / 2.0)]).astype(np.int64) @ [m, 1]
    exists = free[there] & free[here[:, None] + halves[0]] & free[here[:, None] + halves[1]]
    length = CELL * np.hypot(moves[:, 0], moves[:, 1])
    weights = 0.5 * length * (flat[here][:, None] + flat[there])
    count = np.zeros(n * m + 1, dtype=np.int32)
    count[here + 1] = exists.sum(axis=1)
    first = np.cumsum(count, dtype=np.int32)
    from scipy.sparse import csr_array  # slow to import; see `HolisticController`

    return csr_array((weights[exists], there[exists].astype(np.int32), first), shape=(n * m, n * m))


class CostField:
    """Cost to drive to one goal from anywhere: metres, more of them beside obstacles.

    Infinite where there is no path.

    Args:
        floor: graph of the places where the base fits; None if it does everywhere.
        goal: x and y [m].
    """

    def __init__(self, floor: Floor | None, goal: tuple[float, float]) -> None:
        self.goal = goal
        self._floor = floor
        if floor is None:
            return
        from scipy.sparse.csgraph import dijkstra  # slow to import; see `HolisticController`

        self._costs: Array
        self._costs, self._next = dijkstra(
            floor.graph, indices=floor.nearest_node(goal), return_predecessors=True
        )

    def at(self, points: Array) -> Array:
        """Costs (N,) from points (N, 2) to the goal [m]."""
        points = np.asarray(points, dtype=float).reshape(-1, 2)
        direct = np.hypot(points[:, 0] - self.goal[0], points[:, 1] - self.goal[1])
        if self._floor is None:
            return direct
        nodes, away = self._floor.nodes_around(points)
        found: Array = (self._costs[nodes] + away).min(axis=0)
        return np.maximum(found, direct)

    def ahead_of(self, points: Array) -> Array:
        """Places (N, 2) a little ahead on the paths from points (N, 2) to the goal [m]."""
        goal = np.asarray(self.goal)
        if self._floor is None:
            return np.broadcast_to(goal, points.shape)
        nodes, away = self._floor.nodes_around(points)
        best = (self._costs[nodes] + away).argmin(axis=0)
        here = np.take_along_axis(nodes, best[None], axis=0)[0]
        for _ in range(_NEXT):
            here = np.where(self._next[here] < 0, here, self._next[here])
        cells = np.stack(np.divmod(here, int(self._floor.last[1]) + 1), axis=1)
        return self._floor.low + CELL * cells

    def way_from(self, point: tuple[float, float]) -> Array | None:
        """Places (N, 2) from a point to the goal, node by node; None if there is no path."""
        goal = np.array([self.goal])
        if self._floor is None:
            return np.concatenate([[point], goal])
        nodes, away = self._floor.nodes_around(np.array([point]))
        costs, columns = self._costs, int(self._floor.last[1]) + 1
        node = int(nodes[np.argmin(costs[nodes[:, 0]] + away[:, 0]), 0])
        if not np.isfinite(costs[node]):
            return None
        way = [node]
        while (node := int(self._next[node])) >= 0:  # the goal has no next node
            way.append(node)
        cells = np.stack(np.divmod(np.array(way), columns), axis=1)
        return np.concatenate([[point], self._floor.low + CELL * cells, goal])
