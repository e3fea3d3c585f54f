"""From a character to compressed textures."""
