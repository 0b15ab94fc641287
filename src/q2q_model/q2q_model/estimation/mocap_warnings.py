"""What a motion-capture server gets wrong for longer than a moment, for the log and for diagnostics.

The filter goes on without what is wrong (q2q_model.estimation.position), but somebody should land and look at
the markers.
"""

from q2q_model.counted import listed
from q2q_model.estimation.filter_report import FrameWarnings
from q2q_model.estimation.rejected_shares import RejectedShares

LASTING = 0.35
"""Time for which a fault must last to be reported [s]: names are exchanged, and frames repeated, for less."""

_WORDS = {
    "exchanged": "names exchanged by motion capture: {}; tracked by motion: land and check their markers",
    "frozen": "repeated poses rejected: {}; check that motion capture sees these vehicles",
    "rejected": "many samples rejected: {}; jump_max or position_noise may be too small",
    "outside": "positions beyond pos_max rejected: {}; check that they are in metres",
    "not_unit": "quaternions not of unit length rejected: {}; check that they are x, y, z, w",
    "upside_down": "upside down by their quaternions: {}; check the order x, y, z, w and the markers",
    "low_rate": "frame rate too low for coast_s, one missing frame loses vehicles: {}",
    "missing": "no position of {}: check its markers and its name in motion capture",
}


class MocapWarnings:
    """Lasting faults of the frames so far, and which of them were reported."""

    def __init__(self) -> None:
        self.text = ""
        """Lasting faults of the last frame; empty if there are none."""
        self._rejected = RejectedShares()
        self._since: dict[tuple[str, str], float] = {}  # kind and vehicle: stamp of the first such frame [s]

    def update(self, t: float, wrong: FrameWarnings) -> str:
        """Return what to log of a frame at t [s]; empty if nothing has changed."""
        many = self._rejected.update(t, wrong.rejected)
        if not (any(wrong) or many or self._since):
            return ""
        kinds = {**wrong._asdict(), "rejected": many}
        now = {(kind, name) for kind, names in kinds.items() for name in names}
        kept = {one: since for one, since in self._since.items() if since <= t}  # the clock may be set back
        self._since = {one: kept.get(one, t) for one in sorted(now)}
        before, self.text = self.text, self._lasting(t)
        if self.text == before:
            return ""
        return self.text or "motion capture is good again"

    def _lasting(self, t: float) -> str:
        """Return what has lasted, with the vehicles."""
        lasting = [one for one, since in self._since.items() if t - since > LASTING]
        named = {text: [name for kind, name in lasting if kind == wrong] for wrong, text in _WORDS.items()}
        return "; ".join(text.format(listed(names)) for text, names in named.items() if names)
