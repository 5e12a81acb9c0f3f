"""The facts of a scan as the tiles at the top of its page."""

from fusion.certainty.sigma import without_words
from fusion.report.kit.page import Number
from fusion.results.facts import ScanFacts
from fusion.results.words import gap_words, hidden_words, size_words, step_words, volume_words, worse_words


def fact_numbers(facts: ScanFacts) -> list[Number]:
    """What a person asks first: how large, how much, how whole; then how well it was scanned."""
    shape, table = facts.shape, facts.table
    size, unit = size_words(shape)
    volume = volume_words(shape)
    hidden = hidden_words(table) if table is not None and table.hidden > 0 else ""
    numbers = [
        Number("Smallest upright box", size, unit, "width x depth x height"),
        Number("Height", size.rsplit(" ", 1)[-1], unit, hidden),
    ]
    if volume is not None:
        numbers.append(Number("Volume", *volume, "holes closed flat" if shape.holes else ""))
    parts = f"in {shape.fragments:,} parts" if shape.fragments > 1 else ""
    numbers += [Number("Surface", shape.openings(), "", parts), Number("Triangles", f"{shape.triangles:,}")]
    if facts.frames:
        numbers.append(Number("Frames placed", f"{facts.placed} of {facts.frames}"))
    if facts.residual is not None:
        numbers.append(Number("Residual of the frames", f"{facts.residual * 1e3:.2f}", "mm rms"))
    if facts.sure is not None:
        note = f"one standard deviation along the normal; 95 % below {1e3 * facts.sure.high:.2f} mm"
        note += f"; {without_words(facts.sure.unknown)}" * bool(facts.sure.unknown)
        numbers.append(Number("How sure a vertex is", f"{1e3 * facts.sure.middle:.2f}", "mm", note))
    if facts.off_course is not None:
        error, against = facts.off_course.error, facts.off_course.against
        note = f"median {error.median * 1e3:.1f}, max {error.max * 1e3:.1f} mm, against {against}"
        numbers.append(Number("Trajectory error", f"{error.rmse * 1e3:.1f}", "mm rms", note))
    if table is not None:
        mean, std = step_words(table)
        rests = f", {table.rests} frames stand as the one before" if table.rests else ""
        numbers.append(Number("Turn a frame", mean, "deg", f"std {std} deg{rests}"))
        if table.gap is not None:
            numbers.append(Number("Closing gap", gap_words(table.gap), "", worse_words(table)))
    return numbers
