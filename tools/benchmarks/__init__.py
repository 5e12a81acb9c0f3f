"""How fast: stages beside their peers, commands as a person waits for them."""
