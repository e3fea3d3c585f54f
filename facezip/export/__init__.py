"""A pack in the form that a target takes: one module a target."""

from facezip.export.web import export_web

TARGETS = {"web": export_web}
