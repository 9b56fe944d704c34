"""Scene of the page: characters, floor, the path of a joint and onion skins, as nodes of viser."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from usd_tools.characters.body import Body
from usd_tools.figures.style import TRUTH, look

if TYPE_CHECKING:
    import viser

ORIGINAL, SLERP, OURS = "original", "slerp", "ours"
COLORS = {ORIGINAL: TRUTH, SLERP: look("slerp").color, OURS: look("geodesic").color}
"""The characters, from the back to the front, and the papers' colours."""

_ROOT = "/world"
_AXES = {"y": np.array([0.0, 1.0, 0.0]), "z": np.array([0.0, 0.0, 1.0])}


def rgb(color: str) -> tuple[int, int, int]:
    """Read a colour such as #7b3fb5."""
    return int(color[1:3], 16), int(color[3:5], 16), int(color[5:7], 16)


class SceneView:
    """Nodes of a server that show characters; poses come as matrices of joints.

    Parameters
    ----------
    server : viser.ViserServer
    up : str
        "y" or "z".
    bounds : array-like, shape=[2, 3]
        Box that the original stays in, metres.
    standing : array-like, shape=[2, 3]
        Box of its first frame.
    on_click : callable
        Called with the name of a character, and origin and direction of the ray in its space.
    """

    def __init__(
        self,
        server: viser.ViserServer,
        up: str,
        bounds: np.ndarray,
        standing: np.ndarray,
        on_click: Callable[[str, np.ndarray, np.ndarray], None],
    ) -> None:
        self._server, self._up, self._on_click = server, _AXES[up], on_click
        self._level = 1.0 - self._up
        self.size = max(float(np.linalg.norm(standing[1] - standing[0])), 1e-6)
        self.bodies: dict[str, Body] = {}
        self._nodes: dict[str, list[Any]] = {}
        self._frames: dict[str, Any] = {}
        self._offset = np.zeros(3)
        self._sides = dict.fromkeys(COLORS, np.zeros(3))
        self._extras: dict[str, Any] = {}
        server.scene.set_up_direction(tuple(self._up))
        self._root = server.scene.add_frame(_ROOT, show_axes=False)
        self._add_floor(bounds)
        self._frame_camera(standing, bounds)

    def _add_floor(self, bounds: np.ndarray) -> None:
        """Lay a grid below the character, in cells of a power of ten metres."""
        cell = 10.0 ** np.round(np.log10(self.size / 3.0))
        width = 40.0 * cell + 2.0 * float(((bounds[1] - bounds[0]) * self._level).max())
        middle = 0.5 * (bounds[0] + bounds[1]) * self._level
        self._server.scene.add_grid(
            f"{_ROOT}/floor",
            width=width,
            height=width,
            plane="xz" if self._up[1] else "xy",
            cell_size=cell / 2.0,
            section_size=cell,
            cell_color=(225, 226, 234),
            section_color=(205, 207, 220),
            position=middle + bounds[0] * self._up,
        )

    def _frame_camera(self, standing: np.ndarray, bounds: np.ndarray) -> None:
        """Look at where the original begins, from the front, with room below for the time line."""
        camera, middle = self._server.initial_camera, 0.5 * (standing[0] + standing[1])
        side = np.array([1.0, 0.0, 0.0])
        front = np.cross(side, self._up)
        # the camera follows, so that what travels far need not be seen as a whole
        reach = float(np.clip(0.9 * np.linalg.norm(bounds[1] - bounds[0]), 1.9 * self.size, 2.6 * self.size))
        camera.up = self._up
        camera.look_at = middle - 0.16 * reach * self._up
        camera.position = middle + reach * (0.25 * side + 0.9 * front + 0.15 * self._up)
        camera.near, camera.far = 0.005 * self.size, 200.0 * self.size

    def set_body(self, name: str, body: Body, matrices: np.ndarray, opacity: float | None, in_colors: bool) -> None:
        """Draw a character anew, with another body or in other colours."""
        for node in self._nodes.get(name, []):
            node.remove()
        if name not in self._frames:
            self._frames[name] = self._server.scene.add_frame(f"{_ROOT}/{name}", show_axes=False)
        body = body if in_colors and any(part.color for part in body.parts) else body.joined()
        nodes = []
        for i, (part, points) in enumerate(zip(body.parts, body.points(matrices), strict=True)):
            node = self._server.scene.add_mesh_simple(
                f"{_ROOT}/{name}/{i}",
                points.astype(np.float32),
                part.faces.astype(np.uint32),
                color=part.color or rgb(COLORS[name]),
                opacity=opacity,
                side="double",
                receive_shadow=False,
            )
            node.on_click(self._clicked(name))
            nodes.append(node)
        self.bodies[name], self._nodes[name] = body, nodes

    def _clicked(self, name: str) -> Callable[[Any], None]:
        def clicked(event: Any) -> None:
            self._on_click(name, np.array(event.ray_origin) - self.offset(name), np.array(event.ray_direction))

        return clicked

    def offset(self, name: str) -> np.ndarray:
        """Return how far a character is drawn from its place in the world, shape=[3], metres."""
        return self._offset + self._sides[name]

    def joint_at(self, name: str, matrices: np.ndarray, origin: np.ndarray, direction: np.ndarray) -> int | None:
        """Find the joint of a character that a ray meets; see `Body.joint_at`."""
        return self.bodies[name].joint_at(matrices, origin, direction)

    def show(self, poses: Mapping[str, np.ndarray], follow: np.ndarray | None, marked: np.ndarray | None) -> None:
        """Show a pose of each visible character: one message per part.

        Parameters
        ----------
        poses : mapping of str to array-like, shape=[B, 3, 4]
            Matrices of the joints, by character.
        follow : array-like, shape=[3]
            Place that stays in the middle, so that the world moves and the camera is the user's; None: the world stays.
        marked : array-like, shape=[3]
            Place of the chosen joint; None for none.
        """
        with self._server.atomic():
            for name, matrices in poses.items():
                for node, points in zip(self._nodes[name], self.bodies[name].points(matrices), strict=True):
                    node.vertices = points.astype(np.float32)
            offset = np.zeros(3) if follow is None else -follow * self._level
            if (offset != self._offset).any():
                self._root.position = self._offset = offset
            if "mark" in self._extras and marked is not None:
                self._extras["mark"].position = marked + self._sides[OURS]

    def set_visible(self, names: Iterable[str]) -> None:
        """Show some of the characters, and hide the others."""
        shown = set(names)
        for name, frame in self._frames.items():
            frame.visible = name in shown

    def set_side_by_side(self, names: Iterable[str] | None, width: float) -> None:
        """Stand characters side by side, the widths of their box apart; None: all in their own place."""
        order = [] if names is None else list(names)
        for name, frame in self._frames.items():
            place = order.index(name) - 0.5 * (len(order) - 1) if name in order else 0.0
            self._sides[name] = np.array([place * width, 0.0, 0.0])
            frame.position = self._sides[name]

    def set_mark(self, place: np.ndarray | None) -> None:
        """Mark the chosen joint by a ball."""
        self._remove("mark")
        if place is not None:
            self._extras["mark"] = self._server.scene.add_icosphere(
                f"{_ROOT}/mark", radius=0.025 * self.size, color=(216, 27, 96), position=place + self._sides[OURS]
            )

    def set_paths(self, paths: Mapping[str, np.ndarray]) -> None:
        """Draw the paths of a joint, shape=[F, 3], as lines in the colours of their characters; none removes them."""
        for name in COLORS:
            self._remove(f"path-{name}")
            if len(paths.get(name, ())) > 1:
                points = paths[name] + self._sides[name]
                self._extras[f"path-{name}"] = self._server.scene.add_line_segments(
                    f"{_ROOT}/path-{name}",
                    np.stack([points[:-1], points[1:]], axis=1).astype(np.float32),
                    rgb(COLORS[name]),
                    thickness=2.5,
                    thickness_units="screen",
                )

    def set_onion(self, poses: np.ndarray) -> None:
        """Draw some poses of ours, shape=[K, B, 3, 4], as one pale mesh; none removes it."""
        self._remove("onion")
        parts = self.bodies[OURS].joined().parts if len(poses) else ()
        if parts:
            points = parts[0].markers.places(poses)
            starts = points.shape[1] * np.arange(len(poses))
            self._extras["onion"] = self._server.scene.add_mesh_simple(
                f"{_ROOT}/onion",
                (points.reshape(-1, 3) + self._sides[OURS]).astype(np.float32),
                (parts[0].faces + starts[:, None, None]).reshape(-1, 3).astype(np.uint32),
                color=rgb(COLORS[OURS]),
                opacity=0.13,
                cast_shadow=False,
                receive_shadow=False,
            )

    def _remove(self, name: str) -> None:
        node = self._extras.pop(name, None)
        if node is not None:
            node.remove()
