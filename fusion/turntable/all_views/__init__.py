"""All views at once: one axis, one angle a view, the log as a prior."""
