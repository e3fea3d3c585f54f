"""The machine: its cores, work by rows, memory that is bounded, progress."""
