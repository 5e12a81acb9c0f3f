"""Parts of the benchmark: workloads, environments of the peers, the contest, the judge, the pictures."""
