"""Cases that break the rule and are not mended yet, each with the reason; this list should be empty.

The tests demand that each of them still fails: an entry that is mended must go.
"""

MISLED = "a file that is neither recording nor mesh: the line speaks of the result's ending instead"

OPEN: dict[str, str] = {
    "found: depth_image_with_right_sums/half_the_rows": "libpng's own line reaches stderr where fusion is a library",
    "mesh: a web address cube.glb: convert": "the line names the address, not the file that holds it",
    "seen: 1e300 points.npz: compare": "an IndexError is shown as a fault of the program",
    "colour: rgb.txt names escape codes: convert": "a colour image that is missing is left out without a word",
    "colour: rgb.txt names missing: convert": "a colour image that is missing is left out without a word",
    "place: a mesh over a link to nothing: convert": "the line names the temporary place",
    "BOP: an empty object: convert": "the line names the folder, not scene_camera.json",
    "no recording: a text: convert": MISLED,
    "no recording: an empty file: convert": MISLED,
    "no recording: a mesh: convert": MISLED,
    "no recording: a link to /dev/zero: convert": MISLED,
    "no recording: a PNG: convert": MISLED,
    "no recording: a FIFO: convert": MISLED,
    "place: a mesh over a link to nothing --overwrite: convert": "the line names the temporary place",
    "option: wall --set ambient_lux=1e300: simulate": "a light that no scene has is not refused",
    "option: turntable --set elevation_deg=1e300: simulate": "an angle that nobody means is not refused",
    "Open3D: matrix row by row: convert": "a matrix whose last row is not 0 0 1 is not refused",
    "collision: a mesh called telemetry.csv: convert": "the mesh of scene.json becomes the result's telemetry.csv",
}
