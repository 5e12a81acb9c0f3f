"""What every page is made of: parts, tables, colours, the view of a mesh."""
