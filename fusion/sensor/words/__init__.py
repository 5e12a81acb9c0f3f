"""A sensor model in words for a person: names, quantities with their digits, rows of a table."""
