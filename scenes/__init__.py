"""What is rendered: the procedural character, cameras and light rigs, as plain Mitsuba scene dicts."""
