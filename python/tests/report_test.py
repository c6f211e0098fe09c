"""Pages of studies: the numbers of the results, and the call."""

import html
import json
import re

import pytest

import consimd

STUDY = dict(points=200, outliers=(0.5, 0.9), sigma=(0.5, 2.0), trials=3, seed=3)


def tables_of(page):
    text = re.search(r'<script type="application/json" id="data">(.*?)</script>', page, re.DOTALL)[1]
    return {table["name"]: table["rows"] for table in json.loads(text)["tables"]}


def call_of(page):
    return html.unescape(re.search(r'<pre id="command">(.*?)</pre>', page, re.DOTALL)[1])


def nothing(source, target, noise_bound, seed):
    return None


def test_of_a_sweep(tmp_path):
    file = tmp_path / "study/report.html"
    result = consimd.sweep(**STUDY, solvers={"mine": nothing, "tcf": None}, out=tmp_path / "study", report=file)
    page = file.read_text(encoding="utf-8")
    rows = tables_of(page)["cells"]
    assert len(rows) == len(result.cells) == 8
    for row, cell in zip(rows, result.cells):
        for name in result.cells.dtype.names:
            value = row[name] if result.cells.dtype[name].kind == "U" else float(row[name])
            assert value == cell[name], name
    call = call_of(page)
    assert call.startswith("consimd.sweep(points=200, outliers=[0.5, 0.9], sigma=[0.5, 2.0], trials=3, ")
    assert "solvers={'mine': nothing, 'tcf': None}" in call
    assert f"report={str(file)!r}" in call


def test_of_a_sweep_without_a_folder(tmp_path):
    consimd.sweep(**STUDY, report=tmp_path / "report.html")
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "<th>complete</th><td>true</td>" in page
    assert "solvers" not in call_of(page)  # the default


def test_of_a_comparison(tmp_path):
    result = consimd.compare(synthetic="trees", trials=2, solvers=("tcf", "ransac"), report=tmp_path / "report.html")
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    table = result.tables["solvers"]
    assert [list(row.values()) for row in tables_of(page)["table_solvers"]] == table.rows
    assert [(row["method"], row["runs"]) for row in tables_of(page)["methods"]] == [("tcf", 2), ("ransac", 2)]
    assert call_of(page).startswith("consimd.compare(synthetic='trees', ")


@pytest.mark.parametrize("run", [consimd.sweep, consimd.compare])
def test_errors_come_before_the_study(tmp_path, run):
    with pytest.raises(RuntimeError, match=r"no/report\.html: cannot write"):
        run(report=tmp_path / "no/report.html")
    with pytest.raises(ValueError, match=r"r\.pdf: expected a name that ends in \.html"):
        run(report=tmp_path / "r.pdf")
