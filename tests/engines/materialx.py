"""MaterialX's own libraries, and the GLSL that its generator makes of a document."""

from functools import cache

import pytest


@cache
def libraries():
    """The node definitions of MaterialX, and where its sources are."""
    mx = pytest.importorskip("MaterialX", reason="MaterialX is not installed: pip install materialx")
    document, where = mx.createDocument(), mx.getDefaultDataSearchPath()
    mx.loadLibraries(mx.getDefaultDataLibraryFolders(), where, document)
    return document, where


def read(file):
    """A document over the libraries."""
    import MaterialX as mx

    definitions, _ = libraries()
    document = mx.createDocument()
    mx.readFromXmlFile(document, str(file))
    document.setDataLibrary(definitions)
    valid, reason = document.validate()
    assert valid, reason
    return document


def glsl(document, name):
    """The text of a fragment shader that shows what a node gives."""
    from MaterialX.PyMaterialXGenGlsl import GlslShaderGenerator
    from MaterialX.PyMaterialXGenShader import GenContext

    generator = GlslShaderGenerator.create()
    context = GenContext(generator)
    context.registerSourceCodeSearchPath(libraries()[1])
    shown = document.getNode(name)
    if shown.getType() != "surfaceshader":
        output = document.getOutput("shown") or document.addOutput("shown")
        output.setType(shown.getType())
        output.setNodeName(name)
        shown = output
    return generator.generate("shown", shown, context).getSourceCode("pixel")
