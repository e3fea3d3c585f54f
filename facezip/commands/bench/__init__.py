"""``facezip bench``: the main jobs measured on this machine, one verb a module.

What is measured lies with what it measures: ``facezip.fit.timing``, ``facezip.fit.sharing``,
``facezip.export.timing``, ``render.bench``, ``reports.paper.generated``.
"""

import click

from facezip.commands.bench import alarms, batch, clean, compress, maps, metrics, render, rig, scaling, shader


@click.group("bench")
def command() -> None:
    """Measure the main jobs on this machine, each beside what it is compared with."""


for verb in (compress, scaling, render, metrics, clean, rig, maps, batch, alarms, shader):
    command.add_command(verb.command)
