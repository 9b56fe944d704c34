"""The time line: which second is shown, while it plays and while it stands."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass
class Clock:
    """Seconds of a clip, by seconds on the wall.

    Parameters
    ----------
    start, end : float
        First and last second of the clip.
    speed : float
        Seconds of the clip per second.
    loops : bool
        Whether it begins anew at the end; else it stops there.
    """

    start: float
    end: float
    speed: float = 1.0
    loops: bool = True
    is_playing: bool = False
    _shown: float = 0.0
    _since: float = 0.0

    def __post_init__(self) -> None:
        """Begin at the start."""
        self._shown = self.start

    def play(self, now: float) -> None:
        """Go on from what is shown, from the start if that is the end."""
        if not self.is_playing:
            if self._shown >= self.end:
                self._shown = self.start
            self._since, self.is_playing = now, True

    def pause(self, now: float) -> None:
        """Stand still."""
        self._shown, self.is_playing = self.at(now), False

    def seek(self, second: float, now: float) -> None:
        """Show a second of the clip, and go on from there if it plays."""
        self._shown, self._since = min(max(second, self.start), self.end), now

    def set_speed(self, speed: float, now: float) -> None:
        """Change the speed without a jump."""
        self.seek(self.at(now), now)
        self.speed = speed

    def at(self, now: float) -> float:
        """Return the second of the clip to show; pause at the end if it does not loop."""
        if not self.is_playing:
            return self._shown
        second, length = self._shown + (now - self._since) * self.speed, self.end - self.start
        if second <= self.end:
            return second
        if self.loops and length > 0.0:
            return self.start + (second - self.start) % length
        self._shown, self.is_playing = self.end, False
        return self.end
