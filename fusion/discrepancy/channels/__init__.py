"""Channels beside the mean depth: what the spread of repeated frames and missing depths say."""
