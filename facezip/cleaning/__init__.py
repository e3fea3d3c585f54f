"""What captures add to scans, taken away: misregistration, drift of the exposure, noise of the neutral."""
