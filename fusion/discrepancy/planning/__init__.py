"""Planning: which recording to make next, so that look-alikes part and what is invisible shows."""
