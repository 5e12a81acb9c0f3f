"""What the project is measured, judged and written with; README.md lists the commands."""
