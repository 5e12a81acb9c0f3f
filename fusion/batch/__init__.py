"""A command over many recordings: jobs on Dask's workers, each whole or not at all, a row for each."""
