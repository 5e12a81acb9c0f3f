"""Turntable scans with a planted fault, made and judged without the package under test."""
