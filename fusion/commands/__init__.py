"""The console program: one thin file per command, loaded only when it is called."""
