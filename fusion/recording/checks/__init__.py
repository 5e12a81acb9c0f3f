"""What can be wrong with a recording: one file per kind of doubt, each a function of a sample to findings."""
