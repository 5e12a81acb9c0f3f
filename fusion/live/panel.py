"""A state in words and as a ring, as the page's HTML."""

import math

from fusion.live.state import SECTORS, LiveState

COLORS = {"good": "#3fb950", "weak": "#d29922", "lost": "#f85149"}
RADIUS = 40
WARM = 1800.0  # [s] after which most cameras' depth has settled, see docs/first_scan.md; it may have run before


def panel(state: LiveState) -> str:
    """All that is told beside the pictures."""
    color = COLORS[state.tracking]
    why = f" &ndash; {_plain(state.reason)}" if state.reason else ""
    back = "" if state.back_to is None else f"<br>go back to about {state.back_to % 360:.0f}&deg;"
    away = "" if math.isnan(state.distance) else f"{state.distance:.2f} m, {state.band}"
    left = "" if state.left is None else f", {_time(state.left)} left"
    rows = {
        "state": state.phase,
        "distance": away or "not known yet",
        "exposure": state.exposure or "not known yet",
        "frames": f"{state.recorded} recorded, {state.lost} lost",
        "view": f"{state.tracked} placed, {state.untracked} not, {state.dropped} too late",
        "rate": f"{state.rate:.0f} a second, {1e3 * state.behind:.0f} ms behind",
        "running": f"{_time(state.warm)}{left}",
        "camera": "warm" if state.warm >= WARM else "may still be warming up (half an hour)",
        "memory": f"{state.memory / 2**20:.0f} MB",
    }
    table = "".join(f"<tr><td style='opacity:.6;padding-right:.8em'>{k}</td><td>{v}</td></tr>" for k, v in rows.items())
    return (
        f"<div style='padding:.5em 1em;font-size:.85em'>"
        f"<div><b style='color:{color}'>tracking {state.tracking}</b>{why}{back}</div>"
        f"{ring(state)}<table>{table}</table>"
        f"<div style='opacity:.6'>colour: green within 0.3 mm, red 2 mm or more (noise alone)</div></div>"
    )


def ring(state: LiveState) -> str:
    """The turn as a ring, what was seen of it green, and where the table stands now."""
    arcs = "".join(_arc(k, COLORS["good"] if seen else "#555") for k, seen in enumerate(state.seen))
    angle = math.radians(state.turned)
    x, y = RADIUS * math.sin(angle), -RADIUS * math.cos(angle)
    seen = sum(state.seen) * 360 // SECTORS
    return (
        f"<svg viewBox='-50 -50 100 100' width='110' height='110'>{arcs}<circle cx='{x:.1f}' cy='{y:.1f}' r='5' "
        f"fill='#fff'/><text text-anchor='middle' y='5' fill='currentColor' font-size='16'>{seen}&deg;</text></svg>"
    )


def _arc(sector: int, color: str) -> str:
    a, b = (2 * math.pi * (sector + k) / SECTORS for k in (0.08, 0.92))
    (x0, y0), (x1, y1) = ((RADIUS * math.sin(t), -RADIUS * math.cos(t)) for t in (a, b))
    place = f"M{x0:.1f} {y0:.1f}A{RADIUS} {RADIUS} 0 0 1 {x1:.1f} {y1:.1f}"
    return f"<path d='{place}' fill='none' stroke='{color}' stroke-width='6'/>"


def _time(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 120 else f"{seconds / 60:.0f} min"


def _plain(text: str) -> str:
    return text.replace("&", "&amp;").replace("<", "&lt;")
