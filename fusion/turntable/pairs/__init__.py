"""Views two at a time: how well a turn brings them together, and the equations of small motions."""
