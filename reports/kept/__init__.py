"""Figures that are kept: measured by one command, committed as ``benchmarks/results.csv``, printed by the docs."""
