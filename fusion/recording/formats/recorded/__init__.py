"""Recordings of one file, written by programs that record depth cameras."""
