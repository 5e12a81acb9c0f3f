"""What every stage is asked to reach: fusion's median over the fastest peer's of the same run."""

ASKED = {
    ("integrate", "object"): 0.45,
    ("integrate", "room"): 0.2,
    ("raycast", "object"): 0.4,
    ("raycast", "room"): 0.25,
    ("align", "object"): 0.35,
    ("align", "room"): 0.3,
    ("update", "object"): 0.4,
    ("update", "room"): 0.3,
    ("extract", "object"): 0.5,
    ("extract", "room"): 0.5,
    ("error", "object"): 0.4,
    ("error", "room"): 0.4,
    ("memory", "object"): 0.7,
    ("memory", "room"): 0.7,
    ("distances", "points"): 1.05,
}
STAGES = tuple(dict.fromkeys(stage for stage, _ in ASKED))
PARTS = ("integrate", "raycast", "align")  # no peer does the whole update well: the best of each part are added

# measured elsewhere on two cores for peers that cannot always be installed here
QUOTED = {
    "VDBFusion": "16 ms integrate and 80 ms extract on the object, 315 and 992 ms in the room",
    "small_gicp PLANE_ICP": "66 ms on the object, 1671 ms in the room",
    "libigl signed": "2.94 s for the distances",
    "CloudCompare signed": "2.0 s for the distances",
}
