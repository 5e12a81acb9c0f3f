"""The words of a verdict: one judgement for the terminal, the page and the file, for people who know cameras."""

from collections.abc import Iterator, Sequence

from fusion.discrepancy.decisions import NOISE_ALONE
from fusion.discrepancy.observe.outliers import OutlyingRecording
from fusion.discrepancy.observe.single_pixels import SinglePixel
from fusion.discrepancy.verdict.claim import Claim
from fusion.discrepancy.verdict.content import SIMULATION, Nuisances, Unexplained, Verdict
from fusion.discrepancy.verdict.setting_words import misplaced, mm, setting_words
from fusion.sensor.catalogue import IMPLEMENTED
from fusion.sensor.words.in_words import in_words, plain
from fusion.sensor.words.quantity import shown

CERTAIN = 1e-12  # noise is not known well enough to tell smaller probabilities apart
AT_CHANCE = 0.1  # a probability from which on it is told as so many of 100
CALM = 0.5  # chi2 per tile below which residuals are too small to be true (guess)
FOLLOWED = 3  # recordings that are told by name
AT_EDGES, LIGHT = "across depth edges", "how bright the scene is"
ALL_OF = {
    AT_EDGES: "what is wrong at depth edges",
    LIGHT: "what is wrong with the brightness",
}  # by what a text begins with


def sentence(verdict: Verdict) -> str:
    """The verdict in one sentence: what is missing, how large, how sure, and what stays unexplained where."""
    missing, likely = verdict.missing, verdict.indicated
    left = _left(verdict)
    if missing:
        sure = max(_odds(claim) for claim in missing)
        each = "each " if len(missing) > 1 else ""
        named = "; ".join(map(_named, missing))
        told = f"Missing in the {verdict.against}: {named} - {each}established, {chance(sure)}; {left}."
        return told + _or_its_own(verdict)
    # where poses do not make the rest noise, they may be all that could make up for a law
    if misplaced(verdict.nuisances) and verdict.unexplained.chi2_per_dof <= NOISE_ALONE:
        return f"The poses do not fit these recordings, and before they do no effect can be told: {left}."
    if likely:
        odds = max(_odds(claim) for claim in likely)
        told = "; ".join(map(_named, likely))
        told += f" - likely, {chance(odds)}{_instead(verdict.nuisances_instead)}"
        suggested = f"Nothing is established; what these recordings suggest: {told}; {left}."
        return suggested + _or_its_own(verdict)
    looked, unseen = len(verdict.limits), len(verdict.invisible)
    if verdict.unexplained.rms_m > 0 or not verdict.nothing_missing:
        told = (
            f"{looked} effects were looked for" if looked else "how large others could be is not known before that is"
        )
        return f"No effect that has a name is established: {left}; {told}."
    return (
        f"Nothing is missing: the {verdict.against} explains these recordings, {left}; "
        f"{looked} effects were looked for, {unseen} cannot be seen here."
    )


def _instead(setting: Nuisances | None) -> str:
    """What else explains recordings in which effects are likely, as the end of a clause."""
    words = "" if setting is None else setting_words(setting)
    return f"; or nothing is missing and{words[1:]}" if words else ""


def _or_its_own(verdict: Verdict) -> str:
    """Recordings alone do not say which of the two an error is in."""
    if verdict.against != SIMULATION:
        return ""
    return " Where the camera has no such error it is one of the simulation's own, with the opposite sign."


def name_of(claim: Claim) -> str:
    """The name of a claim in words."""
    if claim.unknown:
        return f"an unknown effect that depends on {', '.join(map(plain, claim.where.variables))}"
    return plain(claim.effect)


def what_it_is(claim: Claim) -> str:
    """One sentence on what the effect of a claim is."""
    kind = IMPLEMENTED.get(claim.effect)
    spot = f"in{_spot(claim).removeprefix(' in')} only: " if _spot(claim) else ""
    return spot + (
        in_words(kind).happens.rstrip(".")
        if kind
        else "an error that no known effect of such a camera makes, kept as a table"
    )


def size_of(claim: Claim) -> str:
    """How much a claim changes of what one sees; empty where nothing is known of it."""
    size = claim.size
    if claim.where.text.startswith(AT_EDGES):
        # what pixels there are off by is a part of the step behind them, whatever the effect
        told = (f"{plain(name).removesuffix(' px')} {', '.join(values)}" for name, values in numbers_of(claim))
        return f"{'; '.join(told)} at depth edges"
    if size.rms_m is not None and size.peak_m is not None:
        return f"typically {mm(size.rms_m)}, up to {mm(size.peak_m)}"
    if size.noise_after_m is not None and size.noise_before_m is not None:
        return f"noise of {mm(size.noise_after_m)} instead of {mm(size.noise_before_m)}"
    if size.missing_after is not None and size.missing_before is not None:
        return f"{100 * size.missing_after:.1f} % of the values missing instead of {100 * size.missing_before:.1f} %"
    return ""


def chance(probability: float) -> str:
    """A false alarm probability in words, inside a sentence."""
    if probability <= CERTAIN:
        return "noise alone would practically never do this"
    if probability < AT_CHANCE:
        digits = max(1, 10 ** (len(str(round(1 / probability))) - 1))
        return f"noise alone would do this about once in {round(1 / probability / digits) * digits:,} such data sets"
    return f"noise alone would do this in {100 * probability:.0f} of 100 such data sets"


def how_sure(claim: Claim, established: bool) -> str:
    """How sure a claim is, in words and numbers."""
    told = f"{'established' if established else 'likely, not established'}; {chance(_odds(claim))}"
    gain = min(claim.evidence.heldout_gain, 1.0)
    what = {"noise": "what is wrong with the noise", "dropout": "what is wrong with the missing values"}
    of = what.get(claim.channel, "all that is wrong with the depth")
    of = ALL_OF.get(claim.where.text.split(":")[0], of)
    return f"{told}; it explains {gain:.0%} of {of}"


def rivals_said(claim: Claim) -> list[str]:
    """The look-alikes of a claim; two that are one only together as one."""
    both, zeros = claim.only_together, claim.zero_of
    single = [name for name in claim.indistinguishable_from if name not in (*both, *zeros)]
    return [*single, *([" with ".join(both)] if both else []), *(f"another zero of the {name}" for name in zeros)]


def numbers_of(claim: Claim) -> Iterator[tuple[str, list[str]]]:
    """Every parameter of a claim with its values, all waves of it, each with its interval."""
    for name, known in claim.parameters.items():
        yield name, [shown(value, std, known.unit, sure) for value, std, sure in known.each()]


def _named(claim: Claim) -> str:
    alike, size = [plain(name) for name in rivals_said(claim)], size_of(claim)
    rivals = f" (or {', '.join(alike)})" if alike else ""
    return name_of(claim) + _spot(claim) + rivals + (f": {size}" if size else "")


def _spot(claim: Claim) -> str:
    """Where a claim is of one place in the image; empty where it is not."""
    middle = {bound.variable: 0.5 * (bound.low + bound.high) for bound in claim.where.region}
    if {*middle} != {"u", "v"}:
        return ""
    return f" in one place of the image, about pixel ({middle['u']:.0f}, {middle['v']:.0f})"


def _odds(claim: Claim) -> float:
    return claim.evidence.false_alarm_probability


def _outlying(outliers: Sequence[OutlyingRecording]) -> str:
    """Recordings that show something that is not in their mesh, or nothing at all, as the end of a clause."""
    said = ""
    for empty, text in ((False, "something that is not in the mesh is left out of"), (True, "nothing was measured in")):
        names = [outlier.recording for outlier in outliers if outlier.empty == empty]
        more = f" and {len(names) - FOLLOWED} more" if len(names) > FOLLOWED else ""
        said += f", {text} {', '.join(names[:FOLLOWED])}{more}" if names else ""
    return said


def _alone(pixels: Sequence[SinglePixel]) -> str:
    """Single pixels that are wrong whatever they see, as the end of a clause."""
    if not pixels:
        return ""
    told = ", ".join(f"({pixel.u}, {pixel.v})" for pixel in pixels[:FOLLOWED])
    more = f" and {len(pixels) - FOLLOWED} more" if len(pixels) > FOLLOWED else ""
    what = f"{len(pixels)} single pixels that are" if len(pixels) > 1 else "a single pixel that is"
    return f", left out {'are' if len(pixels) > 1 else 'is'} {what} off in most recordings: {told}{more}"


def _left(verdict: Verdict) -> str:
    left = _unexplained(verdict.unexplained)
    return left + setting_words(verdict.nuisances) + _outlying(verdict.outliers) + _alone(verdict.single_pixels)


def _unexplained(left: Unexplained) -> str:
    if left.chi2_per_dof < CALM:
        return (
            f"what is left is smaller than what noise and tolerances allow (chi2 {left.chi2_per_dof:.2g}): they are "
            "stated too large, or the frames differ for another reason than noise"
        )
    if left.rms_m <= 0:
        return "what is left is noise"
    worst, every = left.recordings[:FOLLOWED], len(left.recordings)
    where = f", most in {', '.join(worst)}" if worst and every > len(worst) else f", in {', '.join(worst)}"
    with_all = "" if left.suggested_rms_m is None else f" ({mm(left.suggested_rms_m)} with all that is suggested)"
    return f"{mm(left.rms_m)} stay unexplained{with_all}{where if worst else ''}"
