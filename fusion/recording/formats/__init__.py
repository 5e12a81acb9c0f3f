"""One file per recording format that is read; `recording/open.py` lists them in the order in which they are tried."""
