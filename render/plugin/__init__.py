"""A pytest plugin that compares renders with stored references under a test that knows render noise."""
