"""The turntable: what turns, about which axis, by which angles.

`motion.py` reads as the whole: `turning/` finds the object, `pairs/` compares views, `guess/` begins, `all_views/`
closes the loop (`loop.py`: axis and angles from all pairs at once), `model/` finishes against what all frames show;
`table/` is what the object stands on. A room imports only from those before it: pairs, table, all_views, guess.
`circle.py` fits circle and axis to camera centres alone, as published.
"""
