"""What a check found."""

from dataclasses import asdict, dataclass, field
from typing import Any

SEVERITIES = ("ok", "warning", "error")


@dataclass(frozen=True)
class Finding:
    """One thing that was looked at."""

    check: str  # short name of what was looked at
    severity: str  # "ok", "warning" (may be wrong) or "error" (is wrong, or cannot be used)
    seen: str  # what was seen, with its number
    do: str = ""  # what to pass or do instead; empty when nothing needs to be done


@dataclass(frozen=True)
class Findings:
    """What is in a recording and what looks wrong with it."""

    summary: dict[str, Any]  # what is in it: format, frames, size, rate and so on, as plain values
    findings: tuple[Finding, ...] = field(default_factory=tuple)  # one per thing that was looked at
    fingerprint: str = ""  # sha256 by which a report names its input

    @property
    def severity(self) -> str:
        """The worst severity of all findings."""
        return max((finding.severity for finding in self.findings), key=SEVERITIES.index, default="ok")

    def to_dict(self) -> dict[str, Any]:
        """Everything as plain values for JSON."""
        return {
            **self.summary,
            "fingerprint": self.fingerprint,
            "severity": self.severity,
            "findings": [asdict(finding) for finding in self.findings],
        }
