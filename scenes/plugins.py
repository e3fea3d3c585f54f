"""What Mitsuba makes an object of."""

from typing import Any

# A plugin by its type and parameters, other plugins among them, as ``mi.load_dict`` takes it.
Plugin = dict[str, Any]
