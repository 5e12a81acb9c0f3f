"""The demo's object and its recording."""
