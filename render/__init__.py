"""How it is rendered and judged."""
