"""Which effect pays most for its freedom: candidates, regions, scores."""
