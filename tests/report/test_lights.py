"""Traffic lights as HTML: level, subject, reason, what to do."""

from fusion.report.page import Light, Page, render


def test_a_light_says_what_to_do_after_its_reason():
    page = render(
        Page("t", summary=[Light("bad", "Scale", "9 % off.", "Calibrate <it>."), Light("ok", "Mesh", "fine")])
    )
    assert page.index("9 % off.") < page.index("Calibrate &lt;it&gt;.") < page.index("fine")
    assert page.count('class="do"') == 1  # a light without advice has no empty place for it
