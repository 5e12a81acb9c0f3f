"""Recordings written by the formats' own or independent libraries."""
