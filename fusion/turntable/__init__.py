"""The turntable: what turns, about which axis, by which angles; poses in, poses out.

`motion.py` reads as the whole: `turning/` finds the object, `pairs/` compares views, `guess/` begins, `all_views/`
closes the loop, `model/` finishes against what all frames show; `table/` is what the object stands on. A room imports
only from those before it: pairs, table, all_views, guess.
"""
