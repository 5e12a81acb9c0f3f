HEAD = ""


def judged(f): ...


line = row = summary = judged
