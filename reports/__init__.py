"""What a person reads: HTML reports, figures, and the tables of the paper."""
