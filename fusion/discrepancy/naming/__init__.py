"""Naming: which effects of the catalogue, added to the model, explain what the mean depth shows beyond it."""
