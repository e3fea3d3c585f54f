"""Which documents there are: by the name in their format, the type that each is an instance of."""

from pathlib import Path

SCHEMAS = Path(__file__).with_name("schemas")

PUBLISHED = {
    "alignment": "facezip.commands.check:CheckDocument",
    "animation": "render.documents.animation:AnimationDocument",
    "batch": "facezip.commands.batch:BatchDocument",
    "bench-alarms": "render.plugin.alarms:AlarmsDocument",
    "bench-batch": "facezip.commands.bench.batch:BatchBenchDocument",
    "bench-clean": "reports.cleaning:CleanBenchDocument",
    "bench-compress": "facezip.commands.bench.compress:CompressBenchDocument",
    "bench-maps": "facezip.commands.bench.maps:MapsBenchDocument",
    "bench-metrics": "facezip.commands.bench.metrics:MetricsBenchDocument",
    "bench-render": "facezip.commands.bench.render:RenderBenchDocument",
    "bench-rig": "reports.paper.documents.rig:RigBenchDocument",
    "bench-shader": "facezip.export.timing:ShaderDocument",
    "compress": "facezip.fit.documents:CompressDocument",
    "curves": "facezip.export.documents.layers:CurvesDocument",
    "decompress": "facezip.commands.decompress:DecompressDocument",
    "demo": "facezip.commands.demo:DemoDocument",
    "doctor": "facezip.character.diagnosis:Diagnosis",
    "error": "facezip.documents.error:ErrorDocument",
    "export": "facezip.export.documents.export:Export",
    "export-web": "facezip.export.documents.export:WebDocument",
    "extend": "facezip.fit.documents:ExtendDocument",
    "images": "render.plugin.results:ImagesDocument",
    "importance": "reports.importance.documents:ImportanceDocument",
    "info": "facezip.commands.info:InfoDocument",
    "layers": "reports.layers.documents:LayersDocument",
    "pack": "facezip.pack.manifest:ManifestFile",
    "paper": "reports.paper.documents.paper:PaperDocument",
    "pointer": "render.plugin.baseline:PointerDocument",
    "rates": "reports.rates.documents:RatesDocument",
    "record": "facezip.batch.finished:RecordDocument",
    "rig": "facezip.rigging.documents:RigDocument",
    "scaling": "reports.scaling:ScalingDocument",
    "scene": "facezip.viewer.documents:SceneDocument",
    "validation": "render.documents.validation:ValidationDocument",
    "verify": "facezip.commands.verify:VerifyDocument",
    "view": "facezip.commands.view:ViewDocument",
}


def published(name: str) -> str:
    """The text of its schema."""
    return (SCHEMAS / f"{name}.json").read_text(encoding="utf-8")
