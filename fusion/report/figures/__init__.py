"""The pictures of a report, one file per subject; each function gives a Figure that is ready for the page."""
