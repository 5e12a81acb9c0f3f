"""How far tiles may be off for known reasons: covariances whose sizes the data say."""
