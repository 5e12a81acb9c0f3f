"""A sensor model as a file: `sensor.json`, its entries, its maps, and what may stand in them."""
