"""Recordings with concealed effects, made by formulas of their own: nothing here imports the package under trial."""
