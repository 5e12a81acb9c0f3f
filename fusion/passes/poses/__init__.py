"""How the passes lie to each other: searched, ranked, refined together."""
