"""What verbs answer and reports write: frozen dataclasses, each with a published JSON schema (``schemas/``)."""
