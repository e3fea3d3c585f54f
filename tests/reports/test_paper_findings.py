"""Findings are made of the numbers: other numbers, other words."""

import pytest

from facezip.documents.document import from_plain
from reports.paper.documents.paper import PaperDocument
from reports.paper.findings import find

CHARACTER = {
    "name": "ada", "expressions": ["a", "b"], "resolution": [512, 512], "channels": 3, "vertices": 3, "triangles": 1,
    "maps": [{"name": "albedo", "encoding": "srgb", "range": [0.0, 1.0], "channels": 3}], "tiles": [1001], "notes": [],
}  # fmt: skip
CONDITIONS = {
    "processor": "one", "cores": 1, "versions": {}, "times": "", "errors": "", "maps": "", "texture_region": "",
    "texture_sizes": "", "weight_scale": 8, "masks": 53, "restarts": 1, "starts": 3, "mask_counts": [], "seed": 0,
}  # fmt: skip
ROW = {
    "resolution": [512, 512],
    "expressions": 2,
    "rmse": {},
    "seconds": {
        "masks": 1.0, "clustering": 2.0, "stitching": 5.0, "factorisation": 0.5, "paper": 8.5, "refined": 3.0,
    },
    "bytes_on_gpu": {"paper": 10, "refined": 10},
    "bytes_on_gpu_of_51": {"paper": 4_767_744},
    "fetches": {"refined": 6},
}  # fmt: skip


def make_document(**errors):
    """Two expressions; by method their errors, paper and the others as given."""
    per_expression = {
        name: dict(zip("ab", errors.get(name, default), strict=True))
        for name, default in {
            "paper": (2.0, 3.0), "paper_unpermuted": (2.5, 3.5), "pca_4": (3.0, 4.0), "pca_8": (1.0, 2.0),
            "paper_optimised": (1.9, 2.8), "refined": (0.5, 1.0),
        }.items()
    }  # fmt: skip
    return {
        "format": "facezip-paper/1",
        "character": CHARACTER,
        "conditions": CONDITIONS,
        "published": {
            "table_1": [
                {"resolution": [512, 512], "seconds": {"paper": 1102.0}, "megabytes": {"paper": 4.77}},
            ],
            "machine": "another",
            "expressions": 51,
            "expressions_in_memory": 51,
        },
        "table_1": [ROW],
        "figure_6": {
            "resolution": [512, 512],
            "rmse": {name: sum(one.values()) / 2 for name, one in per_expression.items()},
            "rmse_per_expression": per_expression,
        },
        "figure_7_convergence": {
            "resolution": [512, 512],
            "masks": 53,
            "lower_bound": None,
            "gap": {},
            "history": [[9.0, 5.0, 4.0, 4.0], [8.0, 6.0, 5.0, 5.0]],
            "cost": {"paper": 4.0},
            "seconds": {"paper": 1.0},
        },
        "figure_7_masks": {
            "resolution": [512, 512],
            "starts": 3,
            "counts": [
                {"masks": 13, "costs": [1.0, 2.0, 3.0], "rmse": [3.0, 3.1, 3.2], "chosen": {}},
                {"masks": 53, "costs": [1.0, 2.0, 3.0], "rmse": [2.0, 2.1, 2.2], "chosen": {}},
                {"masks": 63, "costs": [1.0, 2.0, 3.0], "rmse": [2.6, 2.5, 2.4], "chosen": {}},
            ],
        },
        "figure_8": None,
        "seconds": {"total": 1.0},
    }


def by_key(document):
    return {finding.key: finding for finding in find(from_plain(document, PaperDocument))}


def test_what_the_paper_found_agrees():
    found = by_key(make_document())
    for key in ("paper_against_pca_4", "permutation", "unpermuted_against_pca_4", "masks", "memory", "time", "sweeps"):
        assert found[key].stance == "agrees", found[key]
    assert "2 of 2" in found["paper_against_pca_4"].here
    assert "2.50 against 3.50" in found["paper_against_pca_4"].here
    assert found["refined"].stance == "beyond"


def test_one_expression_that_pca_holds_better_differs():
    found = by_key(make_document(pca_4=(3.0, 2.9)))
    assert found["paper_against_pca_4"].stance == "differs"
    assert "1 of 2" in found["paper_against_pca_4"].here


def test_errors_that_keep_falling_with_the_masks_differ():
    document = make_document()
    document["figure_7_masks"]["counts"][2]["rmse"] = [1.9, 2.0, 2.1]
    finding = by_key(document)["masks"]
    assert finding.stance == "differs"
    assert "lowest with 63 masks: 1.90" in finding.here


def test_a_search_that_still_moves_at_the_end_differs():
    document = make_document()
    document["figure_7_convergence"]["history"][0][-1] = 3.5
    assert by_key(document)["sweeps"].stance == "differs"


@pytest.mark.parametrize(("bound", "words"), [(3.0, "is left to gain"), (3.6, "that is the optimum")])
def test_the_gap_to_the_bound_is_stated(bound, words):
    document = make_document()
    figure = document["figure_7_convergence"]
    figure["cost"]["paper_optimised"], figure["seconds"]["paper_optimised"] = 3.6, 0.01
    figure["lower_bound"] = bound
    here = by_key(document)["search"].here
    assert words in here
    assert "10.0\N{NO-BREAK SPACE}% lower" in here


def test_what_our_permutation_gains_is_stated():
    here = by_key(make_document(paper_optimised=(1.5, 3.2)))["optimised"].here
    assert "1 of 2" in here
    assert "2.35 against 2.50" in here
    document = make_document()
    del document["figure_6"]["rmse"]["paper_optimised"]
    assert "optimised" not in by_key(document)


def test_a_cost_that_says_nothing_of_the_error_is_told():
    document = make_document()
    for row in document["figure_7_masks"]["counts"]:
        row["costs"] = [1.0, 1.0, 1.0]
    assert "cost_and_error" not in by_key(document)


def test_memory_that_is_not_the_papers_differs():
    document = make_document()
    document["published"]["table_1"][0]["megabytes"]["paper"] = 5.0
    assert by_key(document)["memory"].stance == "differs"
