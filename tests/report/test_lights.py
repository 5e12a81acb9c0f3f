"""Traffic lights as HTML: level, subject, reason, what to do."""

from fusion.report.kit.page import OPEN_WARNINGS, Page, render
from fusion.results.light import Light


def test_a_light_says_what_to_do_after_its_reason():
    page = render(
        Page("t", summary=[Light("bad", "Scale", "9 % off.", "Calibrate <it>."), Light("ok", "Mesh", "fine")])
    )
    assert page.index("9 % off.") < page.index("Calibrate &lt;it&gt;.") < page.index("fine")
    assert page.count('class="do"') == 1  # a light without advice has no empty place for it


def test_the_worst_stands_first_and_each_warning_once():
    warnings = [Light("warning", "", "minor flaw"), Light("ok", "", "usual"), Light("bad", "", "large")]
    warnings += [Light("warning", "", "minor flaw")]
    page = render(Page("t", summary=[Light("ok", "A", "fine"), Light("bad", "B", "broken")], warnings=warnings))
    said = [page.index(text) for text in ("broken", "fine", "large", "minor flaw", "<details>", "usual")]
    assert said == sorted(said)
    assert page.count("minor flaw") == 1


def test_warnings_beyond_the_first_few_are_folded():
    page = render(Page("t", warnings=[Light("warning", "", f"said {k}") for k in range(OPEN_WARNINGS + 3)]))
    assert "3 more warnings" in page and page.index(f"said {OPEN_WARNINGS - 1}") < page.index("<details>")
    assert "more warnings" not in render(Page("t", warnings=[Light("warning", "", "one")]))


def test_notes_alone_make_no_section_of_warnings():
    page = render(Page("t", summary=[Light("ok", "A", "fine")], warnings=[Light("ok", "", "usual")]))
    assert "Warnings" not in page and page.index("fine") < page.index("<summary>1 note") < page.index("usual")
