"""Options of `metric`."""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path

from usd_tools.console.errors import UsageError
from usd_tools.console.options import option
from usd_tools.upsampling.options import StyleOptions


def _preset(value: str | Path) -> str | Path:
    return Path(value) if str(value).endswith(".json") else value


@dataclass(frozen=True, kw_only=True)
class MetricOptions(StyleOptions):
    """Options of setting a metric, in the words of the command line; at least one setting is needed.

    Those of `StyleOptions` are not repeated here.

    Parameters
    ----------
    preset : str or Path
        Name of a preset that comes with the program, or a JSON file that a session has saved; styles come after it.
    """

    preset: str | Path | None = option(None, _preset)

    def check(self) -> None:
        """Refuse values that do not go together."""
        super().check()
        if self.metric == "learn":
            raise UsageError("--metric cannot be learn here; usd_tools.learn stores what it learns")
        settings = [each.name for each in fields(StyleOptions) if each.name in StyleOptions.__annotations__]
        if all(getattr(self, name) in (None, ()) for name in (*settings, "preset")):
            raise UsageError("name what to set: --preset, --scheme, --alpha, --joint or others")
