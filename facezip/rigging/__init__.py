"""Example-based facial rigging: a few scans of a person and a template become that person's own 52 shapes."""
