"""Every algorithm once as a textbook has it: one pixel, point, voxel, ray or cell per item, nothing made fast.

Read these first, in this order: `point_map` (depth to points and normals), `icp` (what pairs of points say about a
pose), `blocks` and `integration` (depth into the volume), `raycast` (the volume seen from a camera), `surface` (the
volume as triangles), `turntable` (all frames against one model). `view` and `field` hold what several of them need: how
a camera sees a point, and how the field is read between voxels.

They take and give what the tuned ones do (`compute/choice.py` has the table), share no kernel with them, and are what
those are tested against. With FUSION_KERNELS=plain whole scans run on them.
"""
