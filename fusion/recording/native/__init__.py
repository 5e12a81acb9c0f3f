"""The files of a native folder: cameras, trajectories, telemetry, scene and device."""
